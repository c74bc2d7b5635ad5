#include "engrave/motion/commands/error_judge.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

ErrorJudge::ErrorJudge(const drive::AxisDrives& drives, double rate_hz, const Vec3& start,
                       double limit)
    : limit_(limit),
      compensation_(drives, rate_hz, {start, Vec3::Zero()}),
      prediction_(drives, rate_hz, start) {
  Require(limit > 0, "the limit {} of an error must be positive", limit);
}

void ErrorJudge::Receive(Segment planned) {
  planned.point = -1;  // what is behind is judged no more
  compensation_.Append(planned, commands_);
  for (const Segment& command : commands_) prediction_.Append(command, places_);
  commands_.clear();
}

bool ErrorJudge::Judge(std::span<const Segment> planned, std::size_t count,
                       std::vector<bool>& too_fast) const {
  DriveCompensation compensation = compensation_;
  ErrorPrediction prediction = prediction_;
  std::vector<Segment> commands;
  std::vector<Vec3> points(count, Vec3::Zero());
  for (const Segment& segment : planned) {
    compensation.Append(segment, commands);
    if (segment.point >= 0)
      points.at(static_cast<std::size_t>(segment.point)) = segment.end_position_mm;
  }
  compensation.Finish(commands);
  std::vector<PredictedPlace> places;
  for (const Segment& command : commands) prediction.Append(command, places);
  std::vector<double> errors(count, 0);
  for (const PredictedPlace& place : places) {
    const auto step = static_cast<std::size_t>(place.point);
    errors.at(step) = (place.axes - points[step]).norm();
  }
  too_fast.assign(count, false);
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (errors[i] <= limit_ || (i > 0 && errors[i - 1] > errors[i]) ||
        (i + 1 < count && errors[i + 1] > errors[i])) {
      continue;
    }
    any = too_fast[i] = true;
    if (i > 0) too_fast[i - 1] = true;
    if (i + 1 < count) too_fast[i + 1] = true;
  }
  return any;
}

}  // namespace intaglio::motion
