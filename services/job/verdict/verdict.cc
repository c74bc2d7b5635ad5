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

namespace {

/// Every point is made.
ShopVerdict GoodBut(const Warnings& warnings) {
  std::vector<std::string> texts;
  for (const Warning& warning : AtLeast(WarningWeight::kWarning, warnings)) {
    texts.push_back(warning.text);
  }
  if (texts.empty()) return {VerdictKind::kGood, ""};
  return {VerdictKind::kGoodWithWarnings, fmt::format("{}", fmt::join(texts, "; "))};
}

}  // namespace

VerdictKind VerdictFromName(std::string_view name) {
  for (const VerdictKind kind : {VerdictKind::kNone, VerdictKind::kNotGood,
                                 VerdictKind::kGoodWithWarnings, VerdictKind::kGood}) {
    if (name == VerdictName(kind)) return kind;
  }
  return VerdictKind::kUnknown;
}

ShopVerdict VerdictOf(bool done, const EngraveOutcome* outcome,
                      const Warnings& warnings) {
  if (outcome == nullptr) {
    if (!done) return {VerdictKind::kNone, ""};
    return {VerdictKind::kUnknown, "the outcome of its points is no longer known"};
  }
  const bool touched =
      outcome->made_count() + outcome->missed_count() + outcome->uncertain_count() > 0;
  if (!done && !touched) return {VerdictKind::kNone, ""};
  std::vector<std::string> reasons;
  const auto add = [&reasons](std::uint64_t count, const char* what) {
    if (count > 0) reasons.push_back(fmt::format("{} {}", count, what));
  };
  add(outcome->missed_count(), "missed");
  add(outcome->skipped_count(), "skipped");
  add(outcome->uncertain_count(), "uncertain");
  if (reasons.empty() && outcome->made_count() != outcome->planned_count()) {
    reasons.push_back(fmt::format("{} of them made", outcome->made_count()));
  }
  if (done && reasons.empty()) return GoodBut(warnings);
  if (reasons.empty()) reasons.push_back("not finished");
  return {VerdictKind::kNotGood, fmt::format("of {} points {}", outcome->planned_count(),
                                             fmt::join(reasons, ", "))};
}

}  // namespace intaglio
