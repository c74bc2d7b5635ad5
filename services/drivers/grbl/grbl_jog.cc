#include "services/drivers/grbl/grbl_jog.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio::drivers {
namespace {

constexpr double kMinJogFeed_mm_min = 1;
constexpr double kStatusDecimals_mm = 0.0006;
constexpr double kPerMm = 1e4;  // decimals of a move

// Differences of rounded ends: their sum does not drift.
double MoveBetween(double from_mm, double to_mm) {
  return (std::round(to_mm * kPerMm) - std::round(from_mm * kPerMm)) / kPerMm;
}

}  // namespace

bool IsSameGrblPlace(const Vec3& a_mm, const Vec3& b_mm, const Vec3& steps_per_mm) {
  const double off_steps =
      ((a_mm - b_mm).array() * steps_per_mm.array()).abs().maxCoeff();
  return off_steps <= 1 + kStatusDecimals_mm * steps_per_mm.maxCoeff();
}

void GrblJogMoves::Begin(const Vec3& from_mm, const Vec3& steps_per_mm) {
  *this = {};
  steps_per_mm_ = steps_per_mm;
  end_mm_ = from_mm;
}

Vec3 GrblJogMoves::Snapped(const Vec3& place_mm) const {
  Vec3 snapped = place_mm;
  for (int i = 0; i < 3; ++i) {
    if (steps_per_mm_[i] <= 0) continue;
    snapped[i] = end_mm_[i] + std::round((place_mm[i] - end_mm_[i]) * steps_per_mm_[i]) /
                                  steps_per_mm_[i];
  }
  return snapped;
}

std::optional<std::string> GrblJogMoves::Line(const Vec3& to_mm,
                                              double speed_mm_s) const {
  const Vec3 end_mm = Snapped(to_mm);
  if (end_mm == end_mm_) return std::nullopt;
  std::string line = "$J=G91";
  for (int i = 0; i < 3; ++i) {
    if (end_mm[i] != end_mm_[i])
      line += fmt::format("{}{:.4f}", "XYZ"[i], MoveBetween(end_mm_[i], end_mm[i]));
  }
  return line + fmt::format("F{:.0f}", std::max(kMinJogFeed_mm_min, speed_mm_s * 60));
}

void GrblJogMoves::TakeSent(const Vec3& to_mm) {
  end_mm_ = Snapped(to_mm);
  ++sent_;
}

void GrblJogMoves::TakeStatus(const GrblStatus& status, std::size_t left,
                              std::size_t unanswered) {
  if (sent_ == 0) return;
  if (status.state == GrblState::kIdle && left == 0) {
    was_cut_ =
        !status.work_mm || !IsSameGrblPlace(*status.work_mm, end_mm_, steps_per_mm_);
    sent_ = answered_ = 0;
    waits_for_rest_ = was_cut_;
    return;
  }
  const std::size_t executed = sent_ - std::min(left, sent_);
  if (answered_ > 0 && executed >= answered_) waits_for_rest_ = true;
  answered_ = sent_ - std::min(unanswered, sent_);
}

std::string WhyGrblJogWasCut() {
  return "the controller ended the motion by hand before its place, as a hold at it "
         "does: "
         "check why, then move it again";
}

}  // namespace intaglio::drivers
