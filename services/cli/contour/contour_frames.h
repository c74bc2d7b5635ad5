#pragma once

// An animation of a course: pictures at equal times, and a table of them.

#include <filesystem>
#include <optional>
#include <string>

#include "services/cli/contour/contour_motion.h"

namespace intaglio::cli {

struct FrameOptions {
  std::filesystem::path folder;  ///< made when it is not there
  std::optional<double> step_s;  ///< between frames; default a hundredth of the time
  int width_px = 960, height_px = 720;
};

inline constexpr std::size_t kMaxFrames = 10'000;

/// frame_00001.png ... : contours that are to come and that are made, as wide as the
/// tool, the tool in its place, the time and the speed; and frames.csv with frame,
/// time_s, x_mm, y_mm, speed_mm_s and kind. The first frame is at 0, the last at the end.
/// Returns their number. kTooLarge: more than kMaxFrames; else errors of the disk.
Result<std::size_t> WriteFrames(const ContourWork& work, const ContourMotion& motion,
                                double tool_diameter_mm, const FrameOptions& options);

}  // namespace intaglio::cli
