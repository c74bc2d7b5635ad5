#pragma once

// One frame on a serial line.
//
//   offset  size  field
//        0     2  0xA5 0x5A
//        2     1  version, 13
//        3     1  type
//        4     4  session
//        8     2  sequence number, from 1; 0: unsequenced
//       10     2  acknowledged: the next sequence number that is expected
//       12     2  credit: frames that the sender of this one can still take
//       14     2  payload length, 0..1024
//       16     n  payload
//     16+n     4  CRC-32 (IEEE) of bytes 2 .. 15+n
// All numbers little endian.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace intaglio::link {

/// Grows with every change of a frame or payload; frames of another one are dropped.
inline constexpr std::uint8_t kFrameVersion = 13;
inline constexpr std::size_t kMaxPayload = 1024;
inline constexpr std::size_t kFrameOverhead = 20;

struct FrameHeader {
  std::uint8_t type = 0;
  std::uint32_t session = 0;
  std::uint16_t sequence = 0;
  std::uint16_t acknowledged = 0;
  std::uint16_t credit = 0;
};

/// Appends the frame's bytes to `out`. payload.size() <= kMaxPayload.
void AppendFrame(const FrameHeader& header, std::span<const std::byte> payload,
                 std::vector<std::byte>& out);

/// Finds frames in a stream of bytes. After garbage it goes on at the next sync bytes; a
/// whole frame is delivered with its last byte, whatever precedes it, unless its first
/// bytes are those that an unfinished frame lacks. Holds no more than one unfinished
/// frame between two calls.
class FrameParser {
 public:
  using Sink = std::function<void(const FrameHeader&, std::span<const std::byte>)>;

  /// Takes bytes; calls `sink` for every whole frame with a right CRC.
  void Feed(std::span<const std::byte> bytes, const Sink& sink);

  std::uint64_t dropped_bytes() const { return dropped_bytes_; }
  std::uint64_t bad_crc_count() const { return bad_crc_count_; }

 private:
  bool ParseOne(const Sink& sink);
  std::optional<std::size_t> SizeAt(std::size_t at) const;
  bool IsWholeAt(std::size_t at) const;
  std::size_t NextSync(std::size_t from) const;
  bool DropUpTo(std::size_t at);
  std::vector<std::byte> buffer_;
  std::size_t start_ = 0;
  std::uint64_t dropped_bytes_ = 0;
  std::uint64_t bad_crc_count_ = 0;
};

}  // namespace intaglio::link
