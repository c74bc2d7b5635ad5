// Any bytes as two messages of each numbered type: no more are missing than lie between
// two numbers, and the same message twice has no gap.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "services/recorder/sequence_gaps.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace intaglio::recorder;
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  SequenceGaps gaps;
  std::uint32_t channel = 0;
  for (const SequencedType& type : SequencedTypes()) {
    ++channel;
    const auto first = bytes.first(size / 2), second = bytes.subspan(size / 2);
    if (gaps.Before(channel, type.type, first) != 0) std::abort();
    (void)gaps.Before(channel, type.type, second);
    if (gaps.Before(channel, type.type, second) != 0) std::abort();
  }
  return 0;
}
