#include "engrave/drawing/hpgl_scale.h"

namespace intaglio::drawing {
namespace {

constexpr double kIsotropic = 1, kByFactor = 2;
constexpr double kMiddle_percent = 50;

double SignOf(double x) { return x < 0 ? -1 : 1; }

}  // namespace

void HpglScale::SwitchOff() {
  scale_.clear();
  factor_ = Vec2::Ones();
  offset_ = Vec2::Zero();
  wrong_.reset();
}

std::optional<HpglScale::Wrong> HpglScale::TakeScale(const std::vector<double>& numbers) {
  SwitchOff();
  if (numbers.empty()) return std::nullopt;
  const double kind = numbers.size() > 4 ? numbers[4] : 0;
  if (numbers.size() < 4 || (numbers.size() > 5 && kind != kIsotropic) ||
      numbers.size() > 7) {
    return Wrong{ErrorCode::kInvalidValue,
                 "a scale has four numbers, its kind, and for kind 1 two shares of the "
                 "free space; plot the drawing again"};
  }
  if (kind != 0 && kind != kIsotropic && kind != kByFactor) {
    return Wrong{ErrorCode::kInvalidValue,
                 "a scale is of kind 0, 1 or 2; plot the drawing again"};
  }
  scale_ = numbers;
  Update();
  return std::nullopt;
}

std::optional<HpglScale::Wrong> HpglScale::TakePoints(
    const std::vector<double>& numbers) {
  if (numbers.size() != 0 && numbers.size() != 2 && numbers.size() != 4) {
    return Wrong{ErrorCode::kInvalidValue,
                 "a scaling point has two numbers; plot the drawing again"};
  }
  if (numbers.empty()) {
    p1_ = Vec2(Vec2::Zero());
    p2_.reset();
    Update();
    return std::nullopt;
  }
  const Vec2 p1(numbers[0], numbers[1]);
  if (numbers.size() == 4) {
    p2_ = Vec2(numbers[2], numbers[3]);
  } else if (p1_ && p2_) {
    *p2_ += p1 - *p1_;
  }
  p1_ = p1;
  Update();
  return std::nullopt;
}

void HpglScale::TakePointsOfPage() {
  p1_.reset();
  p2_.reset();
  Update();
}

void HpglScale::Update() {
  if (!scale_.empty()) wrong_ = FindUnits();
}

std::optional<HpglScale::Wrong> HpglScale::FindUnits() {
  const bool by_factor = scale_.size() > 4 && scale_[4] == kByFactor;
  const Vec2 low(scale_[0], scale_[2]);
  const Vec2 second(scale_[1], scale_[3]);
  const Vec2 span = by_factor ? second : Vec2(second - low);
  if ((span.array() == 0).any()) {
    return Wrong{ErrorCode::kInvalidValue,
                 "the scale has no width or no height; plot the drawing again"};
  }
  if (!p1_ || (!by_factor && !p2_)) {
    return Wrong{ErrorCode::kUnsupported,
                 "the drawing has a scale for a page whose size is not in the file; plot "
                 "it with scaling points (IP) or in plotter units, without SC"};
  }
  offset_ = *p1_;
  if (by_factor) {
    factor_ = span;
  } else if (const auto wrong = UpdateByPoints(span)) {
    return wrong;
  }
  offset_ -= factor_.cwiseProduct(low);
  return std::nullopt;
}

/// Computes the factor, and stores the position of the low corner in the offset.
std::optional<HpglScale::Wrong> HpglScale::UpdateByPoints(const Vec2& span) {
  const Vec2 room = *p2_ - *p1_;
  if ((room.array() == 0).any()) {
    return Wrong{ErrorCode::kInvalidValue,
                 "the scaling points (IP) of the drawing have the same x or the same y; "
                 "plot the drawing again"};
  }
  factor_ = room.cwiseQuotient(span);
  if (scale_.size() < 5 || scale_[4] != kIsotropic) return std::nullopt;
  const double smallest = factor_.cwiseAbs().minCoeff();
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const auto share = static_cast<std::size_t>(5 + axis);
    const double percent = scale_.size() > share ? scale_[share] : kMiddle_percent;
    factor_[axis] = smallest * SignOf(factor_[axis]);
    offset_[axis] += percent / 100 * (room[axis] - factor_[axis] * span[axis]);
  }
  return std::nullopt;
}

}  // namespace intaglio::drawing
