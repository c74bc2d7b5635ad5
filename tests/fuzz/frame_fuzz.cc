// Any bytes on a serial line: every frame that the parser delivers occurs in them
// completely, a frame after them is delivered with its last byte, and what a decoder
// accepts encodes to the same bytes again. Where its first bytes complete a frame of
// theirs, it is delivered when it is repeated, as the link does.

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "services/platform/link/frame.h"
#include "services/platform/link/laser_protocol.h"
#include "services/platform/link/motion_protocol.h"
#include "services/platform/link/scan_head_protocol.h"

namespace {

using namespace intaglio::link;

constexpr std::uint32_t kLastSession = 0x1a57;

template <typename T>
void Try(std::span<const std::byte> payload) {
  const auto message = Decode<T>(payload);
  if (!message) {
    if (message.error().message.empty()) std::abort();
    return;
  }
  const Bytes again = Encode(*message);
  if (!std::equal(again.begin(), again.end(), payload.begin(), payload.end())) {
    std::abort();
  }
}

void TryAll(std::span<const std::byte> payload) {
  Try<LampCommand>(payload);
  Try<ShutterCommand>(payload);
  Try<ArmWindow>(payload);
  Try<LaserIdentity>(payload);
  Try<LaserStatus>(payload);
  Try<PulseReport>(payload);
  Try<PastRequest>(payload);
  Try<PulseTiming>(payload);
  Try<PastReport>(payload);
  Try<AccessoryCommand>(payload);
  Try<AccessoryState>(payload);
  Try<BeginRun>(payload);
  Try<Segments>(payload);
  Try<MotionIdentity>(payload);
  Try<MotionStatus>(payload);
  Try<Positions>(payload);
  Try<BeginTimedRun>(payload);
  Try<TimedSegments>(payload);
  Try<TimedPositions>(payload);
  Try<ControllerClock>(payload);
  Try<StageTolerance>(payload);
  Try<StageSpeed>(payload);
  Try<JogMove>(payload);
  Try<MoveBlock>(payload);
  Try<HeadPermit>(payload);
  Try<HeadBegin>(payload);
  Try<HeadBlock>(payload);
  Try<HeadPastRequest>(payload);
  Try<HeadIdentity>(payload);
  Try<HeadStatus>(payload);
  Try<HeadMarks>(payload);
  Try<HeadWeb>(payload);
  Try<HeadPrint>(payload);
  Try<HeadPast>(payload);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto input = std::as_bytes(std::span(bytes, size));
  FrameParser parser;
  bool in_input = true, last_seen = false, completed = false;
  const auto sink = [&](const FrameHeader& header, std::span<const std::byte> payload) {
    Bytes again;
    AppendFrame(header, payload, again);
    const bool found = std::search(input.begin(), input.end(), again.begin(),
                                   again.end()) != input.end();
    if (in_input && !found) std::abort();
    last_seen = header.session == kLastSession;
    completed |= !in_input && !last_seen;
    TryAll(payload);
  };
  // In two pieces, so that frames lie across.
  parser.Feed(input.first(size / 2), sink);
  parser.Feed(input.subspan(size / 2), sink);
  in_input = false;
  Bytes last;
  AppendFrame({0x03, kLastSession, 0, 1, 1}, {}, last);
  parser.Feed(last, sink);
  if (completed && !last_seen) parser.Feed(last, sink);
  if (!last_seen) std::abort();
  if (size <= kMaxPayload) TryAll(input);
  return 0;
}
