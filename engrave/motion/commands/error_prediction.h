#pragma once

// Where the axes will be at their points: commands of a plan, followed by the model of
// their drive (engrave/drive/drive.h) before the job. In the axes' units, mm or rad.

#include <array>
#include <vector>

#include "engrave/drive/drive.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

/// Where the axes are at the end of a segment that makes a point.
struct PredictedPlace {
  std::int32_t point = -1;
  Vec3 axes = Vec3::Zero();
};

class ErrorPrediction {
 public:
  /// The commands begin at rest at `start`. Throws PreconditionError unless rate_hz > 0.
  ErrorPrediction(const drive::AxisDrives& drives, double rate_hz, const Vec3& start);

  /// Follows a segment of commands; adds its place when it ends at a point.
  void Append(const Segment& commanded, std::vector<PredictedPlace>& out);

 private:
  drive::AxisDrives drives_;
  double rate_hz_;
  KnotState from_;
  std::array<drive::AxisState, 3> states_;
};

}  // namespace intaglio::motion
