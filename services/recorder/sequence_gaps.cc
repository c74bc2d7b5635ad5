#include "services/recorder/sequence_gaps.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

namespace intaglio::recorder {
namespace {

constexpr std::array kTypes = {SequencedType{"intaglio::Alarm", "s"},
                               SequencedType{"intaglio::MotionSegmentBatch", "su"},
                               SequencedType{"intaglio::PathBatch", "suuuu"},
                               SequencedType{"intaglio::PointBatch", "suuuu"},
                               SequencedType{"intaglio::PositionReport", "su"},
                               SequencedType{"intaglio::PulseEventBatch", "s"}};

/// Nothing has to be remembered of streams that ended long ago.
constexpr std::size_t kMaxStreams = 4096;

/// Reads a message from its beginning (XTypes 1.3, 7.4: a header of four bytes, members
/// aligned to their size, to four bytes at most in CDR2).
class Beginning {
 public:
  explicit Beginning(std::span<const std::byte> message) {
    if (message.size() < 4 || message[0] != std::byte{}) return;
    const auto encoding = static_cast<unsigned>(message[1]);
    const bool second = encoding == 6 || encoding == 7;
    if (encoding > 1 && !second) return;
    swaps_ = ((encoding & 1) != 0) != (std::endian::native == std::endian::little);
    max_alignment_ = second ? 4 : 8;
    bytes_ = message.subspan(4);
  }

  template <typename T>
  std::optional<T> Number() {
    const std::size_t alignment = std::min(sizeof(T), max_alignment_);
    at_ = (at_ + alignment - 1) / alignment * alignment;
    if (at_ > bytes_.size() || bytes_.size() - at_ < sizeof(T)) return std::nullopt;
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), sizeof(T),
                raw.begin());
    if (swaps_) std::ranges::reverse(raw);
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  bool Skip(char member) {
    const auto number = Number<std::uint32_t>();
    if (!number) return false;
    if (member == 'u') return true;
    if (*number > bytes_.size() - at_) return false;
    at_ += *number;
    return true;
  }

  /// All that was read yet.
  std::string Key() const {
    const auto read = bytes_.first(at_);
    return {reinterpret_cast<const char*>(read.data()), read.size()};
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0, max_alignment_ = 8;
  bool swaps_ = false;
};

}  // namespace

std::span<const SequencedType> SequencedTypes() { return kTypes; }

std::uint64_t SequenceGaps::Before(std::uint32_t channel, std::string_view type,
                                   std::span<const std::byte> message) {
  const auto known = std::ranges::find(kTypes, type, &SequencedType::type);
  if (known == kTypes.end()) return 0;
  Beginning beginning(message);
  for (const char member : known->leading) {
    if (!beginning.Skip(member)) return 0;
  }
  std::string key = beginning.Key();
  const auto number = beginning.Number<std::uint64_t>();
  if (!number) return 0;
  if (last_.size() >= kMaxStreams) last_.clear();
  const auto [last, is_first] = last_.try_emplace({channel, std::move(key)}, *number);
  const std::uint64_t before = std::exchange(last->second, *number);
  return is_first || *number <= before ? 0 : *number - before - 1;
}

}  // namespace intaglio::recorder
