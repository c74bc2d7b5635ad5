#include "services/cli/flags/field_options.h"

#include <fmt/format.h>

#include <utility>

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
  const FieldRule& rule = RuleOf(field);
  const std::string unit = UnitText(field.name());
  const std::string text = (unit.empty() ? "" : unit + ", ") + rule.meaning();
  if (!rule.has_default_value()) return text;
  return fmt::format("{}; default {}", text, rule.default_value());
}

}  // namespace intaglio::cli
