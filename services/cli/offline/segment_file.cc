#include "services/cli/offline/segment_file.h"

#include <fmt/format.h>

#include "engrave/core/try.h"

namespace intaglio::cli {

Result<SegmentFile> SegmentFile::Create(const std::filesystem::path& file,
                                        const std::array<machine::Axis, 3>& axes,
                                        const Vec3& start) {
  auto opened = INTAGLIO_TRY(io::AtomicFile::Create(file));
  SegmentFile segments(std::move(opened));
  std::string heading = "tick";
  for (const auto& axis : axes) {
    heading += fmt::format(",{}_{}", axis.name, axis.unit_name());
  }
  for (const auto& axis : axes) {
    heading += fmt::format(",v{}_{}_s", axis.name, axis.unit_name());
  }
  auto begun = segments.file_.Write(heading + ",point\n");
  if (begun) begun = segments.WriteRow({start, Vec3::Zero()}, -1);
  if (!begun) return tl::unexpected(begun.error());
  return segments;
}

Status SegmentFile::Append(const motion::Segment& segment) {
  subticks_ += segment.duration_subticks;
  return WriteRow(segment.end(), segment.point);
}

Status SegmentFile::WriteRow(const motion::KnotState& knot, std::int32_t point) {
  const double tick =
      static_cast<double>(subticks_) / static_cast<double>(motion::kSubticksPerTick);
  return file_.Write(fmt::format("{},{},{},{},{},{},{},{}\n", tick, knot.position_mm.x(),
                                 knot.position_mm.y(), knot.position_mm.z(),
                                 knot.velocity_mm_s.x(), knot.velocity_mm_s.y(),
                                 knot.velocity_mm_s.z(), point));
}

}  // namespace intaglio::cli
