#include "services/cli/flags/field_options.h"

#include <utility>

#include "services/platform/fields/field_text.h"

namespace intaglio::cli {

std::string UnitText(std::string_view field_name) {
  constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
      {"_mm_s", "mm/s"}, {"_mm", "mm"},   {"_deg", "degrees"},
      {"_ms", "ms"},     {"_ppm", "ppm"}, {"_s", "s"},
  };
  for (const auto& [end, unit] : kUnits) {
    if (field_name.ends_with(end)) return std::string(unit);
  }
  return "";
}

std::string FieldHelp(const google::protobuf::FieldDescriptor& field) {
  const std::string unit = UnitText(field.name()), value = DefaultText(field);
  const std::string text = (unit.empty() ? "" : unit + ", ") + RuleOf(field).meaning();
  return value.empty() ? text : text + "; default " + value;
}

}  // namespace intaglio::cli
