#pragma once

// Finds the steps of a plan at whose ends the drives, following their commands, are
// farther from the point than they may be. In the axes' units, mm or rad.

#include "engrave/motion/commands/drive_compensation.h"
#include "engrave/motion/commands/error_prediction.h"
#include "engrave/motion/segments/step_judge.h"

namespace intaglio::motion {

class ErrorJudge final : public StepJudge {
 public:
  /// The plan begins at rest at `start`. `limit` > 0: of the distance from a point, as
  /// one vector of the axes. Throws PreconditionError.
  ErrorJudge(const drive::AxisDrives& drives, double rate_hz, const Vec3& start,
             double limit);

  /// The plan goes on with this segment for good.
  void Receive(Segment planned);

  /// Of neighbouring steps that are beyond the limit it names the worst, the step before
  /// it, whose accelerations still act, and the one behind it, to which they jump.
  bool Judge(std::span<const Segment> planned, std::size_t count,
             std::vector<bool>& too_fast) const override;

 private:
  double limit_;
  DriveCompensation compensation_;
  ErrorPrediction prediction_;
  std::vector<Segment> commands_;
  std::vector<PredictedPlace> places_;
};

}  // namespace intaglio::motion
