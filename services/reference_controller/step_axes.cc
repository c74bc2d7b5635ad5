#include "services/reference_controller/step_axes.h"

#include <cmath>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

// Beyond half a step, so that a command between two steps makes none to and fro.
constexpr double kOwedSteps = 0.55;

}  // namespace

StepAxes::StepAxes(const StepOptions& options, const Vec3& at_mm, Pins& pins,
                   ControllerTime time)
    : options_(options),
      min_period_(static_cast<std::int64_t>(std::ceil(1e9 / options.max_rate_hz))),
      origin_mm_(at_mm),
      actual_mm_(at_mm),
      commanded_mm_(at_mm),
      pins_(pins),
      time_(std::move(time)) {
  stepped_at_.fill(time_.clock() - min_period_);
}

void StepAxes::Follow(const virtual_engraver::CubicCommand& command, double,
                      double to_s) {
  commanded_mm_ = command.At(to_s);
}

double StepAxes::Owed(int axis) const {
  const auto i = static_cast<std::size_t>(axis);
  return (commanded_mm_[axis] - origin_mm_[axis]) * options_.steps_per_mm[axis] -
         static_cast<double>(count_[i]);
}

bool StepAxes::settled() const {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(Owed(axis)) > kOwedSteps) return false;
  return true;
}

bool StepAxes::IsAtSwitch(int axis) const {
  const Input free = FreeInput(axis);
  return pins_.Has(free) && (levels_ & BitOf(free)) == 0;
}

void StepAxes::ShiftPlace(int axis, double by_mm) {
  origin_mm_[axis] += by_mm;
  actual_mm_[axis] += by_mm;
  commanded_mm_[axis] += by_mm;
}

Status StepAxes::TurnTo(int axis, bool on, bool& turned) {
  bool& now = direction_[static_cast<std::size_t>(axis)];
  if (now == on) return {};
  now = on;
  turned = true;
  return pins_.Set(DirectionOutput(axis), on);
}

Status StepAxes::Step() {
  const nanoseconds now = time_.clock();
  std::array<int, 3> way = {};
  bool any = false, turned = false;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double owed = Owed(axis);
    if (!(std::abs(owed) > kOwedSteps) || now - stepped_at_[i] < min_period_) continue;
    way[i] = owed > 0 ? 1 : -1;
    INTAGLIO_TRY(TurnTo(axis, (owed > 0) != options_.reversed[i], turned));
    any = true;
  }
  if (!any) return {};
  if (turned) time_.wait_until(time_.clock() + options_.direction_setup);
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (way[i] == 0) continue;
    INTAGLIO_TRY(pins_.Set(StepOutput(axis), true));
    stepped_at_[i] = time_.clock();
    count_[i] += way[i];
    actual_mm_[axis] =
        origin_mm_[axis] + static_cast<double>(count_[i]) / options_.steps_per_mm[axis];
  }
  time_.wait_until(time_.clock() + options_.pulse);
  for (int axis = 0; axis < 3; ++axis)
    if (way[static_cast<std::size_t>(axis)] != 0)
      INTAGLIO_TRY(pins_.Set(StepOutput(axis), false));
  return {};
}

}  // namespace intaglio::reference_controller
