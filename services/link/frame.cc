#include "services/link/frame.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "engrave/core/check.h"

namespace intaglio::link {
namespace {

constexpr std::byte kSync0{0xA5}, kSync1{0x5A};
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderSize = 16;

template <typename T>
void Put(std::vector<std::byte>& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
  }
}

template <typename T>
T Get(const std::byte* at) {
  T value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint32_t Crc(const std::byte* bytes, std::size_t size) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes), static_cast<uInt>(size)));
}

}  // namespace

void AppendFrame(const FrameHeader& header, std::span<const std::byte> payload,
                 std::vector<std::byte>& out) {
  Require(payload.size() <= kMaxPayload, "payload of {} bytes, at most {} are allowed",
          payload.size(), kMaxPayload);
  const std::size_t begin = out.size();
  out.push_back(kSync0);
  out.push_back(kSync1);
  Put(out, kVersion);
  Put(out, header.type);
  Put(out, header.session);
  Put(out, header.sequence);
  Put(out, header.acknowledged);
  Put(out, header.credit);
  Put(out, static_cast<std::uint16_t>(payload.size()));
  out.insert(out.end(), payload.begin(), payload.end());
  Put(out, Crc(out.data() + begin + 2, out.size() - begin - 2));
}

void FrameParser::Feed(std::span<const std::byte> bytes, const Sink& sink) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  while (ParseOne(sink)) {
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(start_));
  start_ = 0;
}

// True when something was consumed and there may be more.
bool FrameParser::ParseOne(const Sink& sink) {
  const std::size_t size = buffer_.size() - start_;
  if (size < 2) return false;
  const std::byte* at = buffer_.data() + start_;
  const auto drop_to_next_sync = [&] {
    const auto next = std::find(at + 1, at + size, kSync0);
    dropped_bytes_ += static_cast<std::uint64_t>(next - at);
    start_ += static_cast<std::size_t>(next - at);
    return true;
  };
  if (at[0] != kSync0 || at[1] != kSync1) return drop_to_next_sync();
  if (size < kHeaderSize) return false;
  const auto length = Get<std::uint16_t>(at + 14);
  if (Get<std::uint8_t>(at + 2) != kVersion || length > kMaxPayload)
    return drop_to_next_sync();
  const std::size_t whole = kHeaderSize + length + 4;
  if (size < whole) return false;
  if (Crc(at + 2, kHeaderSize - 2 + length) !=
      Get<std::uint32_t>(at + kHeaderSize + length)) {
    ++bad_crc_count_;
    return drop_to_next_sync();
  }
  const FrameHeader header{Get<std::uint8_t>(at + 3), Get<std::uint32_t>(at + 4),
                           Get<std::uint16_t>(at + 8), Get<std::uint16_t>(at + 10),
                           Get<std::uint16_t>(at + 12)};
  start_ += whole;
  sink(header, {at + kHeaderSize, length});
  return true;
}

}  // namespace intaglio::link
