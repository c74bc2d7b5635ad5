#pragma once

// The record of what the tool of a virtual mill or laser cutter did, written to disk as
// it goes: append-only, fixed-size records, readable up to the place where the file was
// cut.
//
//   offset  size  header (48 bytes)          offset  size  record (48 bytes), a step
//        0     8  "INTTOOL1"                      0     8  us since the power-up, at its
//        end 8     4  version, 1                      8    24  x, y, z of its end, mm
//       12     4  record size, 48                32     8  S of the controller
//       16     8  diameter of the tool, mm       40     4  1: spindle or laser is on;
//       else 0 24     8  thickness of the sheet, mm     44     4  CRC-32 of bytes 0..43
//       32     8  its face above z = 0, mm
//       40     4  1: a laser; else a spindle
//       44     4  CRC-32 of bytes 0..43
// All numbers little endian. Frame: the machine's axes as they were at the power-up, true
// places, mm. A step is a straight way from the end of the step before; the first begins
// at 0, 0, 0.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::formats {

/// The tool, and the sheet under it.
struct ToolWayHeader {
  double tool_diameter_mm = 0;    ///< > 0; of a laser the kerf
  double sheet_thickness_mm = 0;  ///< > 0
  double sheet_height_mm = 0;     ///< of its face above z = 0
  bool is_laser = false;
};

struct ToolWayStep {
  std::uint64_t end_us = 0;
  Vec3 end_mm = Vec3::Zero();
  double power = 0;
  bool is_on = false;
};

struct ToolWay {
  ToolWayHeader header;
  std::vector<ToolWayStep> steps;
  std::uint64_t torn_bytes = 0;  ///< behind the last whole record
};

inline constexpr std::size_t kToolWayHeaderSize = 48;
inline constexpr std::size_t kToolWayStepSize = 48;

std::vector<std::byte> EncodeToolWayHeader(const ToolWayHeader& header);
/// Appends the step's record to `out`.
void AppendToolWayStep(const ToolWayStep& step, std::vector<std::byte>& out);

/// kUnreadable when the header is not a tool way's; a record that is damaged, or has a
/// number that is not finite, ends it.
Result<ToolWay> ParseToolWay(std::span<const std::byte> bytes);
/// kIo, kNotFound, kTooLarge (1 GiB); and as ParseToolWay, with the file's name.
Result<ToolWay> ReadToolWay(const std::filesystem::path& file);

}  // namespace intaglio::formats
