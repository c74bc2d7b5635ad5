#pragma once

// One frame of every message on the serial lines, with a name: what the golden bytes
// in tests/data/link_frames.golden hold.

#include <string>
#include <vector>

#include "services/platform/link/byte_codec.h"
#include "services/platform/link/frame.h"
#include "services/platform/link/laser_protocol.h"
#include "services/platform/link/motion_protocol.h"
#include "services/platform/link/scan_head_protocol.h"

namespace intaglio::link {

struct SampleFrame {
  std::string name;
  std::uint8_t type;
  Bytes payload;
};

inline Bytes Epoch(std::uint64_t number) {
  ByteWriter out;
  out.Put(number);
  return out.Take();
}

inline std::vector<SampleFrame> SampleFrames() {
  const auto laser = [](LaserFrame type) { return static_cast<std::uint8_t>(type); };
  const auto motion = [](MotionFrame type) { return static_cast<std::uint8_t>(type); };
  const auto head = [](HeadFrame type) { return static_cast<std::uint8_t>(type); };
  const WireSegment to_a_point{1000000,   -2500000, 20000000, 80000000, -1,
                               100000000, 65536,    true,     false};
  const WireSegment to_rest{1500000, -2500000, 20000000, 0, 0, 0, 98304, false, true};
  return {
      {"Open", 0x01, Epoch(57)},
      {"Opened", 0x02, {}},
      {"KeepAlive", 0x03, {}},
      {"Nack", 0x04, {}},
      {"Refused", 0x05, Epoch(41)},
      {"LampCommand", laser(LaserFrame::kLampCommand), Encode(LampCommand{true, 100})},
      {"ShutterCommand", laser(LaserFrame::kShutterCommand), Encode(ShutterCommand{1})},
      {"ArmWindow", laser(LaserFrame::kArmWindow),
       Encode(ArmWindow{4711,
                        true,
                        {true, false, false, true, false, false, false, false, true},
                        false,
                        12.5,
                        15})},
      {"Disarm", laser(LaserFrame::kDisarm), {}},
      {"Stop", laser(LaserFrame::kLaserStop), {}},
      {"Reset", laser(LaserFrame::kLaserReset), {}},
      {"StatusRequest", laser(LaserFrame::kLaserStatusRequest), {}},
      {"PastRequest", laser(LaserFrame::kPastRequest), Encode(PastRequest{4711, 512})},
      {"PulseTiming", laser(LaserFrame::kPulseTiming),
       Encode(PulseTiming{7.5, 150, 3, 12, 40, -0.5, 80})},
      {"AccessoryCommand", laser(LaserFrame::kAccessoryCommand),
       Encode(AccessoryCommand{0x05, 0x83, 0x81})},
      {"AccessoryState", laser(LaserFrame::kAccessoryState),
       Encode(AccessoryState{3, 8, 0x05, 0x81})},
      {"LaserIdentity", laser(LaserFrame::kLaserIdentity),
       Encode(LaserIdentity{
           0xC0FFEE, true, 4, {50, 100}, "virtual", "A-03", true, 0.5, 30, true})},
      {"LaserStatus", laser(LaserFrame::kLaserStatus),
       Encode(LaserStatus{4720, 47200000, 100, 1, 0x9f, 1, 3, 4719, 4725, 2, 7})},
      {"PulseReport", laser(LaserFrame::kPulseReport),
       Encode(PulseReport{4711,
                          {TickOutcome::kFiredSeen, TickOutcome::kNotArmed,
                           TickOutcome::kFiredUnseen, TickOutcome::kTooLate},
                          {0, 0, 5, 0},
                          {12.25F, 0, 12.75F, 0}})},
      {"PastReport", laser(LaserFrame::kPastReport),
       Encode(PastReport{4711,
                         {TickOutcome::kNoLongerKnown, TickOutcome::kFiredUnseen,
                          TickOutcome::kNotArmed},
                         {0, 8, 0}})},
      {"BeginRun", motion(MotionFrame::kBeginRun),
       Encode(BeginRun{3, 4700, -50000000, 2500})},
      {"Segments", motion(MotionFrame::kSegments),
       Encode(Segments{3, 12, {to_a_point, to_rest}})},
      {"AbortRun", motion(MotionFrame::kAbortRun), {}},
      {"MotionStatusRequest", motion(MotionFrame::kMotionStatusRequest), {}},
      {"MotionReset", motion(MotionFrame::kMotionReset), {}},
      {"MotionIdentity", motion(MotionFrame::kMotionIdentity),
       Encode(MotionIdentity{{0, 0, -1},
                             {300000000, 300000000, 100000000},
                             4096,
                             "ST 7/2",
                             true,
                             true,
                             100,
                             true})},
      {"MotionStatus", motion(MotionFrame::kMotionStatus),
       Encode(MotionStatus{4720, 1, -2, 3, 4, -5, 6, 3, 4800, 4000, 96, false,
                           StageFault::kFollowingError, 12345, 77, -50000000, 2500})},
      {"Positions", motion(MotionFrame::kPositions),
       Encode(Positions{3, 4711, {{1, 2, 3}, {-4, -5, -6}}})},
      {"BeginTimedRun", motion(MotionFrame::kBeginTimedRun),
       Encode(BeginTimedRun{3, 47123456789, -50000000, 2500})},
      {"TimedSegments", motion(MotionFrame::kTimedSegments),
       Encode(TimedSegments{
           3,
           12,
           {{1000000, -2500000, 20000000, 80000000, -1, 100000000, 47133457000, true,
             false},
            {1500000, -2500000, 20000000, 0, 0, 0, 47148459000, false, true}}})},
      {"TimedPositions", motion(MotionFrame::kTimedPositions),
       Encode(
           TimedPositions{3, 4711, {{47110001000, 1, 2, 3}, {47121003000, -4, -5, -6}}})},
      {"ControllerClock", motion(MotionFrame::kControllerClock),
       Encode(ControllerClock{0xC10C, 1700000001})},
      {"StageTolerance", motion(MotionFrame::kStageTolerance),
       Encode(StageTolerance{30000})},
      {"StageSpeed", motion(MotionFrame::kStageSpeed),
       Encode(StageSpeed{80000000, 80000000, 40000000})},
      {"JogMove", motion(MotionFrame::kJogMove),
       Encode(JogMove{1000000, -2000000, 3000000, 20000000})},
      {"MoveBlock", motion(MotionFrame::kMoveBlock),
       Encode(MoveBlock{-50000000, 2500, 30000000})},
      {"Home", motion(MotionFrame::kHome), {}},
      {"HeadPermit", head(HeadFrame::kHeadPermit), Encode(HeadPermit{true})},
      {"HeadBegin", head(HeadFrame::kHeadBegin), Encode(HeadBegin{3})},
      {"HeadBlock", head(HeadFrame::kHeadBlock),
       Encode(HeadBlock{
           3,
           4711,
           {91.25, 0.0625, 20.5F, 15.0625F},
           {{1, true, 12, 0.5F, 20000}, {3, false, 12}},
           {{32768, 32768, false}, {30000, 41017, true}, {30010, 41027, true}}})},
      {"HeadFinish", head(HeadFrame::kHeadFinish), {}},
      {"HeadPause", head(HeadFrame::kHeadPause), {}},
      {"HeadStop", head(HeadFrame::kHeadStop), {}},
      {"HeadReset", head(HeadFrame::kHeadReset), {}},
      {"HeadPastRequest", head(HeadFrame::kHeadPastRequest),
       Encode(HeadPastRequest{3, 12, 100})},
      {"HeadIdentity", head(HeadFrame::kHeadIdentity),
       Encode(
           HeadIdentity{0xC10C, true, 1e5, 100, 65536, 1024, true, "SH 100", "sh-0042"})},
      {"HeadStatus", head(HeadFrame::kHeadStatus),
       Encode(HeadStatus{4720, 0x17, 30000, 41017, 160, 65376, -12, 0.25F, 4700, 5, 3,
                         HeadRunState::kOpen, 12, 11, 2, 9})},
      {"HeadMarks", head(HeadFrame::kHeadMarks),
       Encode(HeadMarks{3, {{11, HeadMarkFate::kDone}, {12, HeadMarkFate::kBegun}}})},
      {"HeadWeb", head(HeadFrame::kHeadWeb),
       Encode(HeadWeb{4500, 100, {{-14, 0.5F}, {-13, 0.25F}}})},
      {"HeadPrint", head(HeadFrame::kHeadPrint),
       Encode(HeadPrint{7, {{4610, -13.75}, {4710, 91.125}}})},
      {"HeadPast", head(HeadFrame::kHeadPast),
       Encode(HeadPast{
           3,
           11,
           {HeadMarkFate::kDone, HeadMarkFate::kBroken, HeadMarkFate::kNoLongerKnown}})},
  };
}

/// The header all of them travel with.
inline FrameHeader HeaderOf(const SampleFrame& sample) {
  return {sample.type, 0xDEADBEEF,
          sample.type < 0x10 ? std::uint16_t{0} : std::uint16_t{7}, 6, 256};
}

inline Bytes Framed(const SampleFrame& sample) {
  Bytes bytes;
  AppendFrame(HeaderOf(sample), sample.payload, bytes);
  return bytes;
}

}  // namespace intaglio::link
