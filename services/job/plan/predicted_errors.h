#pragma once

// How far from its points a plan will meet, by the drives of the profile, where a depth
// within motion.depth_tolerance_um counts as the point's: the planned motion, compensated
// as the job's commands are (engrave/motion/commands), followed by the model of the
// drives, and compared in the glass. The same with the drives' mechanics off by as much
// as a profile may be wrong (WrongMechanics of machine_drives.h).

#include <optional>
#include <vector>

#include "engrave/machine/axes_from_glass.h"
#include "engrave/motion/commands/drive_compensation.h"
#include "engrave/motion/commands/error_prediction.h"
#include "proto/task.pb.h"

namespace intaglio {

class PredictedErrors {
 public:
  /// `path`: the axes at the points, not empty; it has to live as long.
  PredictedErrors(const FrozenJob& job, const PointList& path);

  /// False: the pulses fire at the place and not at the tick, and nothing is predicted.
  bool predicts() const { return !predictions_.empty(); }
  /// The next segment of the plan, not compensated.
  void Append(const motion::Segment& planned);
  void Finish();
  /// In place of Append and Finish: the next segment as commanded, compensated already.
  void AppendCommand(const motion::Segment& commanded);

  /// At the end: distance from each point of the path in the glass, um.
  const std::vector<double>& errors_um() const { return errors_um_; }
  double rms_um() const;
  double max_um() const;
  /// The greatest distance with any of the wrong mechanics, and half a step of the axes
  /// besides, um.
  double wrong_mechanics_max_um() const { return wrong_max_um_ + half_step_um_; }

 private:
  void Follow();
  double ErrorUm(const motion::PredictedPlace& place) const;

  const PointList& path_;
  machine::AxesFromGlass axes_from_glass_;
  double depth_tolerance_mm_, half_step_um_;
  std::optional<motion::DriveCompensation> compensation_;  // none: as planned
  /// The first by the profile; the others with wrong mechanics.
  std::vector<motion::ErrorPrediction> predictions_;
  std::vector<motion::Segment> commands_;
  std::vector<motion::PredictedPlace> places_;
  std::vector<double> errors_um_;
  double wrong_max_um_ = 0;
};

}  // namespace intaglio
