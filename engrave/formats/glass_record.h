#pragma once

// The record of the glass of a virtual machine, written to disk as the pulses happen:
// append-only, fixed-size records, readable up to the place where the file was cut.
//
//   offset  size  header (64 bytes)         offset  size  record (48 bytes)
//        0     8  "INTGLAS1"                     0     8  tick
//        8     4  version, 1 or 2                8    24  x, y, z: glass frame, mm
//       12     4  record size, 48               32     8  pulse energy, mJ
//       16    24  block size x, y, z, mm        40     1  channel, 0..3, plus 4
//                                                     times (station - 1)
//       40     8  refractive index              41     1  1: in the glass, 0: beside it
//       48     8  numerical aperture            42     2  length of the crack, um; 0: not
//       known 56     4  power-up of the laser,        44     4  CRC-32 of bytes 0..43
//                 0: not known
//       60     4  CRC-32 of bytes 0..59
// All numbers little endian.
//
// Since version 2 a record with 2 in byte 41 is no crack but a collision: x, y, z is
// where the focus would be in air, from the corner of the block at station 1;
// bytes 32..39 have how deep the body is in what it met, mm; byte 40 is 0; byte 42 the
// body, 0 the lens, 1 the head above it; byte 43 what it met, 0 a block, else the number
// of a fixture. A collision is recorded when it begins, and again whenever it has become
// 0.1 mm deeper.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::formats {

struct GlassHeader {
  Vec3 block_size_mm = Vec3::Zero();
  double refractive_index = 0;
  double numerical_aperture = 0;
  /// Of the controller whose ticks the cracks have, as in the journal; 0: not known.
  std::uint32_t power_up = 0;
};

struct GlassCrack {
  std::uint64_t tick = 0;
  Vec3 position_mm = Vec3::Zero();  ///< where the marginal rays meet, glass frame
  double pulse_energy_mj = 0;
  std::uint8_t channel = 0;
  bool in_glass = true;  ///< false: the pulse went into the air
  double length_mm = 0;  ///< along the beam, in whole um; 0: not known
  /// In which of the blocks on the table, 1..64; the position is in the frame of this
  /// one.
  std::uint8_t station = 1;
};

/// A part of the head met something on the table.
struct GlassCollision {
  std::uint64_t tick = 0;  ///< the newest that had passed
  Vec3 focus_mm = Vec3::Zero();
  double overlap_mm = 0;
  std::uint8_t body = 0;   ///< 0: the lens, 1: the head above it
  std::uint8_t solid = 0;  ///< 0: a block, else the number of a fixture
};

struct GlassRecord {
  GlassHeader header;
  std::vector<GlassCrack> cracks;
  std::vector<GlassCollision> collisions;
  std::uint64_t torn_bytes = 0;  ///< behind the last whole record
};

inline constexpr std::size_t kGlassHeaderSize = 64;
inline constexpr std::size_t kGlassRecordSize = 48;

std::vector<std::byte> EncodeGlassHeader(const GlassHeader& header);
/// Appends the crack's record to `out`.
void AppendGlassCrack(const GlassCrack& crack, std::vector<std::byte>& out);
void AppendGlassCollision(const GlassCollision& collision, std::vector<std::byte>& out);

/// kUnreadable when the header is not a glass record's.
Result<GlassRecord> ParseGlassRecord(std::span<const std::byte> bytes);
/// With `take_crack` each crack is given to it when it is read, without all of them at
/// once, and the record has none.
Result<GlassRecord> ReadGlassRecord(
    const std::filesystem::path& file,
    const std::function<void(const GlassCrack&)>& take_crack = {});
/// The header alone, of a file of any size.
Result<GlassHeader> ReadGlassHeader(const std::filesystem::path& file);

}  // namespace intaglio::formats
