#pragma once

// The segments of a plan as CSV, for any tools: a heading, then one row a knot, from the
// start at rest (tick 0) on:
//   tick,x_mm,y_mm,z_mm,vx_mm_s,vy_mm_s,vz_mm_s,point
// with the names and units of the machine's axes: arm_rad, table_rad, z_mm, varm_rad_s
// ... Time in ticks of the lamp; between knots the motion is the cubic of
// engrave/motion/segments/segment.h. `point` is the index in the path of the point
// made at the knot, or -1. Numbers are the shortest decimals that give the same doubles;
// a tick has 1/65536 as its least part, so its decimals are exact.

#include <array>
#include <filesystem>

#include "engrave/core/result.h"
#include "engrave/io/atomic_file.h"
#include "engrave/machine/kinematics.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::cli {

class SegmentFile {
 public:
  /// The file takes its name with Commit. Errors are those of the disk.
  static Result<SegmentFile> Create(const std::filesystem::path& file,
                                    const std::array<machine::Axis, 3>& axes,
                                    const Vec3& start);

  Status Append(const motion::Segment& segment);
  Status Commit() { return file_.Commit(); }

 private:
  explicit SegmentFile(io::AtomicFile file) : file_(std::move(file)) {}
  Status WriteRow(const motion::KnotState& knot, std::int32_t point);

  io::AtomicFile file_;
  std::uint64_t subticks_ = 0;
};

}  // namespace intaglio::cli
