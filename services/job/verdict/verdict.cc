#include "services/job/verdict/verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace intaglio {

const char* VerdictName(VerdictKind verdict) {
  switch (verdict) {
    case VerdictKind::kNone:
      return "none";
    case VerdictKind::kUnknown:
      return "unknown";
    case VerdictKind::kNotGood:
      return "not_good";
    case VerdictKind::kGoodWithWarnings:
      return "good_with_warnings";
    case VerdictKind::kGood:
      return "good";
  }
  return "unknown";
}

VerdictKind VerdictFromName(std::string_view name) {
  for (const VerdictKind kind : {VerdictKind::kNone, VerdictKind::kNotGood,
                                 VerdictKind::kGoodWithWarnings, VerdictKind::kGood}) {
    if (name == VerdictName(kind)) return kind;
  }
  return VerdictKind::kUnknown;
}

bool IsGood(VerdictKind verdict) {
  return verdict == VerdictKind::kGood || verdict == VerdictKind::kGoodWithWarnings;
}

ShopVerdict VerdictFor(const std::vector<std::string>& reasons,
                       const Warnings& warnings) {
  if (!reasons.empty())
    return {VerdictKind::kNotGood, fmt::format("{}", fmt::join(reasons, "; "))};
  std::vector<std::string> texts;
  for (const Warning& warning : AtLeast(WarningWeight::kWarning, warnings)) {
    texts.push_back(warning.text);
  }
  if (texts.empty()) return {VerdictKind::kGood, ""};
  return {VerdictKind::kGoodWithWarnings, fmt::format("{}", fmt::join(texts, "; "))};
}

ShopVerdict VerdictOf(bool done, const intaglio_PointCounts& counts,
                      const Warnings& warnings, const std::string& makes) {
  const bool touched = counts.made + counts.missed + counts.uncertain > 0;
  if (!done && !touched) return {VerdictKind::kNone, ""};
  if (counts.planned == 0) {
    return {VerdictKind::kUnknown,
            fmt::format("the outcome of its {} is no longer known", makes)};
  }
  std::vector<std::string> reasons;
  const auto add = [&reasons](std::uint64_t count, const char* what) {
    if (count > 0) reasons.push_back(fmt::format("{} {}", count, what));
  };
  add(counts.missed, "missed");
  add(counts.skipped, "skipped");
  add(counts.uncertain, "uncertain");
  if (reasons.empty() && counts.made != counts.planned) {
    reasons.push_back(fmt::format("{} of them made", counts.made));
  }
  if (done && reasons.empty()) return VerdictFor({}, warnings);
  if (reasons.empty()) reasons.emplace_back("not finished");
  return VerdictFor(
      {fmt::format("of {} {} {}", counts.planned, makes, fmt::join(reasons, ", "))},
      warnings);
}

}  // namespace intaglio
