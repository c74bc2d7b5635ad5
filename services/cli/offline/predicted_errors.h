#pragma once

// How far from its points a plan will meet, by the drive of the profile: the planned
// motion, compensated as the job's commands are (engrave/motion/commands), followed by
// the model of the drive, and compared in the glass.

#include <optional>
#include <vector>

#include "engrave/machine/axes_from_glass.h"
#include "engrave/motion/commands/drive_compensation.h"
#include "engrave/motion/commands/error_prediction.h"
#include "proto/task.pb.h"

namespace intaglio::cli {

class PredictedErrors {
 public:
  /// `path`: the axes at the points, not empty; it has to live as long.
  PredictedErrors(const FrozenJob& job, const PointList& path);

  /// False: the pulses fire at the place and not at the tick, and nothing is predicted.
  bool predicts() const { return prediction_.has_value(); }
  /// The next segment of the plan, not compensated.
  void Append(const motion::Segment& planned);
  void Finish();

  /// After Finish: distance from each point of the path in the glass, um.
  const std::vector<double>& errors_um() const { return errors_um_; }
  double rms_um() const;
  double max_um() const;

 private:
  void Follow();

  const PointList& path_;
  machine::AxesFromGlass axes_from_glass_;
  std::shared_ptr<const drive::Drive> drive_;
  std::optional<motion::DriveCompensation> compensation_;  // none: as planned
  std::optional<motion::ErrorPrediction> prediction_;
  std::vector<motion::Segment> commands_;
  std::vector<motion::PredictedPlace> places_;
  std::vector<double> errors_um_;
};

}  // namespace intaglio::cli
