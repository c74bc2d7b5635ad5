#include "engrave/post/cutting.h"

#include <fmt/format.h>

#include <cctype>

#include "engrave/core/counted.h"

namespace intaglio::post {
std::string ProgramName(std::string_view text) {
  std::string name;
  for (const char c : text) {
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  }
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) {
    name.insert(name.begin(), 'P');
  }
  return name;
}

std::string PartName(const std::string& name, std::size_t part) {
  return part == 0 ? name : fmt::format("{}_{}", name, part + 1);
}

Status RequireName(const Template& program, const std::string& name,
                   std::size_t part_count) {
  const auto max = static_cast<std::size_t>(program.SettingOf("max-name", kMaxName.max));
  const std::string longest = PartName(name, part_count > 0 ? part_count - 1 : 0);
  if (longest.size() <= max) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("{}: the program's name {} has {}, and this "
                  "controller takes {}; give --out a shorter file name",
                  program.file, longest, Counted(longest.size(), "character"), max),
      longest);
}

Status RequireSuited(const Template& program, const TemplateRules& rules,
                     const Cutting& cutting) {
  for (const std::string& variable : cutting.given) {
    if (AnyFragmentUses(program, rules, variable)) continue;
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: no fragment uses @{}@, which is given and would be lost; "
                    "do not give it, or choose or write a template that uses it",
                    program.file, variable),
        variable);
  }
  if (!cutting.power_ratio && AnyFragmentUses(program, rules, "POWER")) {
    return Fail(ErrorCode::kUnsupported,
                program.file +
                    ": this template is for a laser and uses @POWER@; give the power, or "
                    "choose a template for a mill");
  }
  const bool differ =
      std::ranges::adjacent_find(cutting.depths_mm, std::ranges::not_equal_to()) !=
      cutting.depths_mm.end();
  if (differ && !AnyFragmentUses(program, rules, "DEPTH", 1)) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{}: fragment '{}' alone uses @DEPTH@, so that all passes "
                            "would have one depth; make one pass without tabs, "
                            "or choose another template",
                            program.file, rules.fragments[0].name));
  }
  return {};
}

std::vector<Value> CommonValues(const Cutting& cutting, std::string_view name,
                                double depth_mm) {
  return {name,
          std::uint64_t{0},
          cutting.speed_mm_s,
          cutting.travel_mm_s,
          cutting.plunge_mm_s,
          depth_mm,
          cutting.safe_mm,
          cutting.power_ratio.value_or(0),
          cutting.tool_diameter_mm};
}

}  // namespace intaglio::post
