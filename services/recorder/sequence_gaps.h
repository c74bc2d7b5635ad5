#pragma once

// Finds messages that a writer sent and the recorder never received, by the gaps in their
// sequence numbers. It reads the beginning of a message only, as far as the number.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace intaglio::recorder {

/// A type whose messages are numbered without gaps.
struct SequencedType {
  std::string_view type;  ///< as the bus names it
  /// The members in front of sequence_number, in their order: 's' a string, 'u' a uint32.
  /// Numbers count within equal values of these.
  std::string_view leading;
};

std::span<const SequencedType> SequencedTypes();

/// From one thread.
class SequenceGaps {
 public:
  /// How many messages are missing between the last one with equal leading members and
  /// this one, of a channel and in the bus's encoding (CDR or CDR2). 0 for the first, for
  /// a number that does not grow (its writer started anew), for other types, and for
  /// what has another form.
  std::uint64_t Before(std::uint32_t channel, std::string_view type,
                       std::span<const std::byte> message);

 private:
  std::map<std::pair<std::uint32_t, std::string>, std::uint64_t> last_;
};

}  // namespace intaglio::recorder
