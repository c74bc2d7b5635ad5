#include "services/client/proof/evidence/verdict_text.h"

#include <fmt/format.h>

namespace intaglio::client {

double ToleranceUm(const PositionErrors& errors) {
  return errors.tolerance_um() + errors.allowed_move_um();
}

bool KeepsSpacing(const JobReport& report) {
  return report.points().planned() <= 1 ||
         report.measured_spacing_mm() >= report.min_spacing_mm();
}

std::string SpacingText(const JobReport& report) {
  return report.points().planned() == 1
             ? "none: one point"
             : fmt::format("{:.4f} mm", report.measured_spacing_mm());
}

VerdictKind KindOf(const Verdict& verdict) {
  if (verdict.good()) return VerdictKind::kGood;  // older reports have no kind
  return verdict.kind() == VerdictName(VerdictKind::kGoodWithWarnings)
             ? VerdictKind::kGoodWithWarnings
             : VerdictKind::kNotGood;
}

std::string VerdictTitle(const Verdict& verdict, const std::string& good) {
  switch (KindOf(verdict)) {
    case VerdictKind::kGood:
      return good;
    case VerdictKind::kGoodWithWarnings:
      return "GOOD, WITH WARNINGS";
    default:
      return "NOT GOOD";
  }
}

render::Tone ToneOf(const Verdict& verdict) {
  switch (KindOf(verdict)) {
    case VerdictKind::kGood:
      return render::Tone::kGood;
    case VerdictKind::kGoodWithWarnings:
      return render::Tone::kWarning;
    default:
      return render::Tone::kBad;
  }
}

}  // namespace intaglio::client
