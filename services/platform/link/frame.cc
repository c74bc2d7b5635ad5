#include "services/platform/link/frame.h"

#include <algorithm>
#include <cstring>

#include "engrave/core/check.h"
#include "engrave/io/crc32.h"

namespace intaglio::link {
namespace {

constexpr std::byte kSync0{0xA5}, kSync1{0x5A};
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

}  // namespace

void AppendFrame(const FrameHeader& header, std::span<const std::byte> payload,
                 std::vector<std::byte>& out) {
  Require(payload.size() <= kMaxPayload, "payload of {} bytes, at most {} are allowed",
          payload.size(), kMaxPayload);
  const std::size_t begin = out.size();
  out.push_back(kSync0);
  out.push_back(kSync1);
  Put(out, kFrameVersion);
  Put(out, header.type);
  Put(out, header.session);
  Put(out, header.sequence);
  Put(out, header.acknowledged);
  Put(out, header.credit);
  Put(out, static_cast<std::uint16_t>(payload.size()));
  out.insert(out.end(), payload.begin(), payload.end());
  Put(out, io::Crc32(std::span(out).subspan(begin + 2)));
}

void FrameParser::Feed(std::span<const std::byte> bytes, const Sink& sink) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  while (ParseOne(sink)) {
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(start_));
  start_ = 0;
}

// Bytes of the frame that begins at `at`, when its header is complete and valid.
std::optional<std::size_t> FrameParser::SizeAt(std::size_t at) const {
  const std::byte* header = buffer_.data() + at;
  if (buffer_.size() - at < kHeaderSize || header[0] != kSync0 || header[1] != kSync1 ||
      Get<std::uint8_t>(header + 2) != kFrameVersion) {
    return std::nullopt;
  }
  const auto length = Get<std::uint16_t>(header + 14);
  if (length > kMaxPayload) return std::nullopt;
  return kFrameOverhead + length;
}

bool FrameParser::IsWholeAt(std::size_t at) const {
  const auto size = SizeAt(at);
  if (!size || buffer_.size() - at < *size) return false;
  const std::byte* crc = buffer_.data() + at + *size - 4;
  return io::Crc32({buffer_.data() + at + 2, *size - 6}) == Get<std::uint32_t>(crc);
}

std::size_t FrameParser::NextSync(std::size_t from) const {
  const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(from);
  return static_cast<std::size_t>(std::find(begin, buffer_.end(), kSync0) -
                                  buffer_.begin());
}

bool FrameParser::DropUpTo(std::size_t at) {
  dropped_bytes_ += at - start_;
  start_ = at;
  return true;
}

// True when something was consumed and there may be more.
bool FrameParser::ParseOne(const Sink& sink) {
  const std::size_t available = buffer_.size() - start_;
  if (available < 2) return false;
  const std::byte* at = buffer_.data() + start_;
  if (at[0] != kSync0 || at[1] != kSync1) return DropUpTo(NextSync(start_ + 1));
  if (available < kHeaderSize) return false;
  const auto size = SizeAt(start_);
  if (!size) return DropUpTo(NextSync(start_ + 1));
  if (available < *size) {
    // A damaged length would make a quiet line wait longer than its peer's patience: a
    // whole frame inside an unfinished one shows that the latter is none.
    for (std::size_t i = NextSync(start_ + 1); i < buffer_.size(); i = NextSync(i + 1)) {
      if (IsWholeAt(i)) return DropUpTo(i);
    }
    return false;
  }
  if (!IsWholeAt(start_)) {
    ++bad_crc_count_;
    return DropUpTo(NextSync(start_ + 1));
  }
  const FrameHeader header{Get<std::uint8_t>(at + 3), Get<std::uint32_t>(at + 4),
                           Get<std::uint16_t>(at + 8), Get<std::uint16_t>(at + 10),
                           Get<std::uint16_t>(at + 12)};
  start_ += *size;
  sink(header, {at + kHeaderSize, *size - kFrameOverhead});
  return true;
}

}  // namespace intaglio::link
