#include "services/job/plan/predicted_errors.h"

#include <algorithm>
#include <cmath>

#include "services/job/convert/options.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_drives.h"

namespace intaglio {

PredictedErrors::PredictedErrors(const FrozenJob& job, const PointList& path)
    : path_(path),
      axes_from_glass_(AxesFromGlassOf(job)),
      depth_tolerance_mm_(1e-3 * job.job().motion().depth_tolerance_um()),
      half_step_um_(1e3 * HalfStepInGlassMm(job)) {
  if (job.machine().pulse_trigger() == PULSE_TRIGGER_AT_PLACE) return;
  const motion::PlanOptions plan = MotionOptionsOf(job);
  if (plan.continuous) {
    compensation_.emplace(plan.drives, plan.rate_hz,
                          motion::KnotState{path.front(), Vec3::Zero()});
  }
  predictions_.emplace_back(plan.drives, plan.rate_hz, path.front());
  for (const drive::MechanicsRatios& wrong : WrongMechanics())
    predictions_.emplace_back(DrivesWith(wrong, job.machine()), plan.rate_hz,
                              path.front());
  errors_um_.assign(path.size(), 0);
}

void PredictedErrors::Append(const motion::Segment& planned) {
  if (!predicts()) return;
  if (compensation_) {
    compensation_->Append(planned, commands_);
  } else {
    commands_.push_back(planned);
  }
  Follow();
}

void PredictedErrors::AppendCommand(const motion::Segment& commanded) {
  if (!predicts()) return;
  commands_.push_back(commanded);
  Follow();
}

void PredictedErrors::Finish() {
  if (compensation_) compensation_->Finish(commands_);
  Follow();
}

double PredictedErrors::ErrorUm(const motion::PredictedPlace& place) const {
  const Vec3& point = path_.at(static_cast<std::size_t>(place.point));
  Vec3 away_mm = axes_from_glass_.ToGlass(place.axes) - axes_from_glass_.ToGlass(point);
  away_mm.z() = std::max(0.0, std::abs(away_mm.z()) - depth_tolerance_mm_);
  return 1000 * away_mm.norm();
}

void PredictedErrors::Follow() {
  for (std::size_t i = 0; i < predictions_.size(); ++i) {
    places_.clear();
    for (const motion::Segment& command : commands_)
      predictions_[i].Append(command, places_);
    for (const motion::PredictedPlace& place : places_) {
      const double error_um = ErrorUm(place);
      if (i == 0) {
        errors_um_.at(static_cast<std::size_t>(place.point)) = error_um;
      } else {
        wrong_max_um_ = std::max(wrong_max_um_, error_um);
      }
    }
  }
  commands_.clear();
}

double PredictedErrors::rms_um() const {
  double sum = 0;
  for (const double error_um : errors_um_) sum += error_um * error_um;
  return std::sqrt(sum /
                   static_cast<double>(std::max<std::size_t>(errors_um_.size(), 1)));
}

double PredictedErrors::max_um() const {
  return errors_um_.empty() ? 0 : *std::max_element(errors_um_.begin(), errors_um_.end());
}

}  // namespace intaglio
