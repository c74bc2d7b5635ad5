#include "services/virtual_engraver/stage_end.h"

namespace intaglio::virtual_engraver {

using link::MotionFrame;

void StageEnd::Poll() {
  const bool is_new =
      own_line_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
        Obey(static_cast<MotionFrame>(type), payload);
      });
  if (is_new) Greet();
}

void StageEnd::Greet() {
  line().Send(MotionFrame::kMotionIdentity, Encode(stage_.Identity()));
  if (const auto speed = stage_.MaxSpeed())
    line().Send(MotionFrame::kStageSpeed, Encode(*speed));
  line().Send(MotionFrame::kStageTolerance, Encode(stage_.Tolerance()));
  if (const OwnClock* own = stage_.own_clock()) {
    line().Send(MotionFrame::kControllerClock,
                Encode(link::ControllerClock{own->power_up(), own->now_ns()}));
  }
}

void StageEnd::Obey(MotionFrame type, std::span<const std::byte> payload) {
  switch (type) {
    case MotionFrame::kBeginRun:
      if (const auto m = link::Decode<link::BeginRun>(payload)) stage_.BeginRun(*m);
      return;
    case MotionFrame::kSegments:
      if (const auto m = link::Decode<link::Segments>(payload)) stage_.Append(*m);
      return;
    case MotionFrame::kBeginTimedRun:
      if (const auto m = link::Decode<link::BeginTimedRun>(payload))
        stage_.BeginTimedRun(*m);
      return;
    case MotionFrame::kTimedSegments:
      if (const auto m = link::Decode<link::TimedSegments>(payload))
        stage_.AppendTimed(*m);
      return;
    case MotionFrame::kJogMove:
      if (const auto m = link::Decode<link::JogMove>(payload)) stage_.Jog(*m);
      return;
    case MotionFrame::kHome:
      return stage_.Home();
    case MotionFrame::kMoveBlock:
      if (const auto m = link::Decode<link::MoveBlock>(payload)) stage_.MoveBlock(*m);
      return;
    case MotionFrame::kAbortRun:
      // Until now the stage moved on.
      if (before_abort_) before_abort_();
      return stage_.Abort();
    case MotionFrame::kMotionReset:
      return stage_.Reset();
    case MotionFrame::kMotionStatusRequest:
      own_line_.AskForStatus();
      return;
    default:
      return;  // a frame of the laser, or of another version of the protocol
  }
}

void StageEnd::KeepSafe() {
  if (line().silent() && stage_.running()) stage_.Fail(link::StageFault::kSafeState);
}

void StageEnd::SendPositions() {
  for (const link::Positions& positions : stage_.TakePositions())
    line().Send(MotionFrame::kPositions, Encode(positions));
  for (const link::TimedPositions& positions : stage_.TakeTimedPositions()) {
    // They arrive at rest, too: they are not kept for a host that is not there.
    if (!line().is_up()) break;
    line().Send(MotionFrame::kTimedPositions, Encode(positions));
  }
}

void StageEnd::SendStatus(std::chrono::nanoseconds now, bool at_once,
                          std::chrono::nanoseconds period) {
  if (!at_once && stage_.fault() == sent_fault_ && !own_line_.IsStatusDue(now)) return;
  sent_fault_ = stage_.fault();
  own_line_.SetNextStatus(now + period);
  if (line().is_up()) line().Send(MotionFrame::kMotionStatus, Encode(stage_.Report()));
}

}  // namespace intaglio::virtual_engraver
