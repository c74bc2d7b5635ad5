// Any bytes on a serial line: what the parser delivers has the right CRC, what a decoder
// takes encodes to the same bytes again, and nothing reads out of bounds.

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "services/link/frame.h"
#include "services/link/laser_protocol.h"
#include "services/link/motion_protocol.h"

namespace {

using namespace intaglio::link;

template <typename T>
void Try(std::span<const std::byte> payload) {
  const auto message = Decode<T>(payload);
  if (!message) {
    if (message.error().message.empty()) std::abort();
    return;
  }
  // A float's bits may differ (NaN is refused), lengths and the rest may not.
  const Bytes again = Encode(*message);
  if (again.size() != payload.size()) std::abort();
}

void TryAll(std::span<const std::byte> payload) {
  Try<LampCommand>(payload);
  Try<ShutterCommand>(payload);
  Try<ArmWindow>(payload);
  Try<LaserIdentity>(payload);
  Try<LaserStatus>(payload);
  Try<PulseReport>(payload);
  Try<BeginRun>(payload);
  Try<Segments>(payload);
  Try<MotionIdentity>(payload);
  Try<MotionStatus>(payload);
  Try<Positions>(payload);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto input = std::as_bytes(std::span(bytes, size));
  FrameParser parser;
  const auto sink = [](const FrameHeader& header, std::span<const std::byte> payload) {
    Bytes again;
    AppendFrame(header, payload, again);
    if (again.size() != payload.size() + kFrameOverhead) std::abort();
    TryAll(payload);
  };
  // In two pieces, so that frames lie across.
  parser.Feed(input.first(size / 2), sink);
  parser.Feed(input.subspan(size / 2), sink);
  if (size <= kMaxPayload) TryAll(input);
  return 0;
}
