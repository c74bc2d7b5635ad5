#pragma once

// G-code for third-party motion controllers: a move to each point in turn, then a pulse.
// Write only. It contains neither lamp sync nor limits of motion; intaglio's own machines
// are driven by engrave/motion instead. docs/formats.md describes the lines.

#include <array>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"
#include "engrave/formats/point_file.h"

namespace intaglio::formats {

struct GcodeOptions {
  /// Decimals of a coordinate, 0..9. Default 3, 1 um: the stage's resolution, and far
  /// less than a crack.
  int decimals = 3;
  /// Of G1 moves, mm/min, >= 0. Default 0: rapid moves (G0) at the controller's own
  /// speed.
  double feed_mm_min = 0;
  /// The line that fires one pulse, not empty, may be several lines. No command is common
  /// to all controllers; M100 is the first of LinuxCNC's user-defined codes.
  std::string pulse = "M100";
  /// The place of the controller's zero in the frame of the points, mm.
  Vec3 origin_mm = Vec3::Zero();
  /// The address letters of the three coordinates. Those of rotary axes are A, B and C,
  /// in degrees.
  std::array<char, 3> words = {'X', 'Y', 'Z'};
  /// Lines before the first move, and after the last. Default: mm (G21), absolute (G90);
  /// end of program.
  std::string header = "G21\nG90";
  std::string footer = "M2";
};

/// Writes the points in their order; columns are omitted, comments are in parentheses.
/// Atomic; errors are those of the disk. Options outside their ranges are a broken
/// precondition.
Status WriteGcode(const std::filesystem::path& file, const PointTable& table,
                  const GcodeOptions& options = {});

}  // namespace intaglio::formats
