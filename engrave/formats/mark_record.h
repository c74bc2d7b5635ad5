#pragma once

// The record of what a virtual scan head burnt into its material, written to disk as the
// ticks pass: append-only, fixed-size records, readable up to the place where the file
// was cut.
//
//   offset  size  header (32 bytes)         offset  size  record (48 bytes), a lit tick
//        0     8  "INTMARK1"                     0     8  tick
//        8     4  version, 2                     8    16  x, y at its end: material, mm
//       12     4  record size, 48               24     8  way in it along x, y, f32, mm
//       16     8  width of the field, mm        32     4  energy, f32, mJ
//       24     4  power-up of the controller    36     4  run
//       28     4  CRC-32 of bytes 0..27         40     4  mark
//                                               44     4  CRC-32 of bytes 0..43
// All numbers little endian. The frame material moves with the web; on a piece at rest it
// is the field. A print mark that passed the photo eye is a record of the mark 2^32 - 2
// with the place of its edge along x; all else but its tick is 0. Version 1 has none.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::formats {

struct MarkRecordHeader {
  double field_mm = 0;
  std::uint32_t power_up = 0;  ///< of the controller whose ticks these are
};

/// What one tick burnt: a straight way that ends at `place_mm`.
struct BurntTick {
  std::uint64_t tick = 0;
  Vec2 place_mm = Vec2::Zero();
  Vec2 way_mm = Vec2::Zero();
  double energy_mj = 0;
  std::uint32_t run = 0, mark = 0;
};

/// A print mark of the web, which passed the photo eye.
struct PrintMark {
  std::uint64_t tick = 0;
  double place_mm = 0;  ///< of its edge: material, along x
};
/// In place of a mark's number.
inline constexpr std::uint32_t kPrintMark = 0xfffffffe;

struct MarkRecord {
  MarkRecordHeader header;
  std::vector<BurntTick> ticks;
  std::uint64_t torn_bytes = 0;  ///< behind the last whole record
  std::vector<PrintMark> prints = {};
};

inline constexpr std::size_t kMarkHeaderSize = 32;
inline constexpr std::size_t kMarkRecordSize = 48;

std::vector<std::byte> EncodeMarkHeader(const MarkRecordHeader& header);
/// Appends the tick's record to `out`.
void AppendBurntTick(const BurntTick& tick, std::vector<std::byte>& out);

void AppendPrintMark(const PrintMark& mark, std::vector<std::byte>& out);

/// kUnreadable when the header is not a mark record's; a record that is damaged, or has
/// a number that is not finite, ends it.
Result<MarkRecord> ParseMarkRecord(std::span<const std::byte> bytes);
/// kIo, kNotFound, kTooLarge (1 GiB); and as ParseMarkRecord, with the file's name.
Result<MarkRecord> ReadMarkRecord(const std::filesystem::path& file);
/// The header alone, of a file of any size.
Result<MarkRecordHeader> ReadMarkHeader(const std::filesystem::path& file);
/// The file is there whole or not at all. kIo.
Status WriteMarkRecord(const std::filesystem::path& file, const MarkRecord& record);

}  // namespace intaglio::formats
