#pragma once

// Correction files .ct5 of the RTC5 and RTC6 control boards (SCANLAB; the layout by the
// RTC5 manual, "Correction file header", and by published files): 1 056 852 bytes,
// little-endian: 16 int32 of header; four tables of int32, 257 rows (y) of 257 columns
// (x); uint32 check. Outputs and targets are bits of 20, 2^19 is 0.
//   tables 0, 1: output x, y for the target ((i - 128) 4096, (j - 128) 4096)
//   tables 2, 3: the inverse: target for the output at a node, as deviation + 2^19
// The check is the complement of the CRC-32 of all before it in files since 2022; that
// of older files is not known and does not refuse them.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::galvo {

inline constexpr int kCt5Nodes = 257, kCt5NodeBits = 4096, kCt5Zero = 1 << 19;
inline constexpr std::uint64_t kCt5Bytes = 64 + 4ULL * kCt5Nodes * kCt5Nodes * 4 + 4;

/// Numbers of the header by their place; all others are 0 in what is written here.
enum Ct5Field {
  kCt5Type = 0,              ///< 0: two-dimensional
  kCt5Calibration = 1,       ///< K, bit/mm
  kCt5FocalLength = 2,       ///< times 20, mm
  kCt5StretchX = 3,          ///< times 2^35 / K
  kCt5StretchY = 4,          ///< times 2^35 / K
  kCt5FileNumber = 8,        ///< of the lens, by its maker
  kCt5CalibrationAngle = 12  ///< mechanical, 1/1000 degree at 96 % of full output
};

struct Ct5 {
  std::array<std::int32_t, 16> header{};
  std::array<std::vector<std::int32_t>, 4> tables;  ///< 257 x 257 each, row by row
  /// Check of a file that is not the complement of the CRC-32; it is written again.
  std::optional<std::uint32_t> kept_check;

  static std::size_t IndexOf(int x, int y) {
    return static_cast<std::size_t>(y * kCt5Nodes + x);
  }
};

/// Errors begin with the name: kUnreadable (another size), kInvalidValue (no calibration,
/// a node outside 0..2^20 in tables 0 and 1).
Result<Ct5> ReadCt5(std::string_view bytes, std::string_view name);

/// A file that was read is written bit for bit. Throws PreconditionError for tables of
/// another size.
std::string WriteCt5(const Ct5& file);

}  // namespace intaglio::galvo
