#include "services/job/teach/test_points.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

constexpr std::uint32_t kMaxCount = 1000;

Status CheckInside(const Vec3& point_mm, const Vec3& block_mm) {
  for (int i = 0; i < 2; ++i) {
    if (point_mm[i] >= 0 && point_mm[i] <= block_mm[i]) continue;
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("{} would be {:.3f} mm, outside the block of {:g} mm: move "
                            "the axes over it (intaglio teach move)",
                            i == 0 ? "x" : "y", point_mm[i], block_mm[i]));
  }
  return {};
}

}  // namespace

optics::MachineFromGlass TestFrame(const MachineSpec& machine, std::uint32_t channel,
                                   const std::string& lens, const Vec3& block_mm,
                                   double stage_per_glass_ratio) {
  return {BlockOriginOf(machine, channel, lens), block_mm, stage_per_glass_ratio};
}

Result<Vec3> PointUnderFocus(const MachineSpec& machine, const Vec3& axes,
                             const optics::MachineFromGlass& frame) {
  const Vec3 point_mm = frame.ToGlass(KinematicsOf(machine)->ToPlace(axes));
  INTAGLIO_TRY(CheckInside(point_mm, frame.block_size_mm));
  const double height_mm = frame.block_size_mm.z();
  if (point_mm.z() > 0 && point_mm.z() <= height_mm) return point_mm;
  const bool above = point_mm.z() > height_mm;
  const double off_mm = above ? point_mm.z() - height_mm : -point_mm.z();
  return Fail(ErrorCode::kOutsideBlock,
              fmt::format("the focus is {:.3f} mm {} the block by the taught zero: {} it "
                          "(intaglio teach jog z), or check the zero",
                          off_mm * frame.stage_per_glass_ratio, above ? "above" : "below",
                          above ? "lower" : "raise"));
}

Result<PointList> FocusSeriesPoints(const MachineSpec& machine, const Vec3& axes,
                                    const optics::MachineFromGlass& frame,
                                    const FocusSeries& series) {
  if (!(series.step_mm > 0) || !(series.pitch_mm > 0) || series.count < 2 ||
      series.count > kMaxCount) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a series of {}, {} mm deeper each, {} mm apart: give "
                            "2 to {} points and ways above 0",
                            Counted(series.count, "point"), series.step_mm,
                            series.pitch_mm, kMaxCount));
  }
  const Vec3 here_mm = frame.ToGlass(KinematicsOf(machine)->ToPlace(axes));
  const double height_mm = frame.block_size_mm.z();
  PointList points_mm;
  for (std::uint32_t i = 1; i <= series.count; ++i) {
    points_mm.emplace_back(here_mm.x() + (i - 1) * series.pitch_mm, here_mm.y(),
                           height_mm - i * series.step_mm);
  }
  INTAGLIO_TRY(CheckInside(points_mm.front(), frame.block_size_mm));
  INTAGLIO_TRY(CheckInside(points_mm.back(), frame.block_size_mm));
  if (points_mm.back().z() > 0) return points_mm;
  return Fail(ErrorCode::kOutsideBlock,
              fmt::format("{} points with a step of {} mm are deeper than the block, "
                          "{} mm: take fewer, or a smaller step",
                          series.count, series.step_mm, height_mm));
}

Result<double> ZeroMoveOfFirstCrack(const PointList& points_mm, double block_height_mm,
                                    double stage_per_glass_ratio, std::uint32_t first) {
  if (first < 1 || first > points_mm.size()) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("first crack {}: the series has the points 1 to {}", first,
                            points_mm.size()),
                std::to_string(first));
  }
  const double step_mm = points_mm[0].z() - points_mm[1].z();
  if (first == 1) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format(
            "first crack 1: the series began in the glass, so the face is "
            "above it: raise the zero (intaglio teach zero --by 0 0 "
            "{:.3g}) and engrave another series",
            step_mm * stage_per_glass_ratio * static_cast<double>(points_mm.size()) / 2),
        "1");
  }
  const double depth_mm = block_height_mm - points_mm[first - 1].z();
  return -stage_per_glass_ratio * (depth_mm - step_mm / 2);
}

}  // namespace intaglio
