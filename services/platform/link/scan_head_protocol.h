#pragma once

// The messages of the line between a marker (host) and the controller of a scan head
// (device). Each struct is the payload of one frame (services/platform/link/frame.h); all
// numbers little endian, packed in the order of the fields; docs/protocols.md shows the
// bytes.
//
// The controller counts ticks of 10 us from its power-up. The host sends what the mirrors
// and the laser do in each tick, in blocks. Edges in a block are where marks begin and
// end: the controller counts a mark as begun at its edge, before anything of it is burnt,
// and as done behind the last of it, and remembers what became of it.
//   Time: a block with a first tick is played from that tick on; one without (0) behind
//     what is queued. Between two blocks the mirrors rest. A block that comes after its
//     first tick, and an empty queue while a mark is in hand, are an underrun.
//   Web: the host sends ticks ahead, for where it thinks that the web will be. The
//     controller reads the encoder in each tick and adds what the web is elsewhere
//     (HeadFollow), so that how far ahead they are sent does not count.
//   Print: a photo eye before the field sees the marks printed on the web. Each is
//   latched
//     in the tick in which its edge passes, with the encoder's count, and numbered from
//     the power-up on; none is lost, so a gap in the numbers is a fault.
//   Beam: on only in ticks that say so, within a mark, while the newest HeadPermit is
//     younger than 250 ms, key on, door closed, stop released, not in the safe state.
//   Drops: HeadPermit(0), HeadStop, HeadPause, and all that ends the beam, end the run:
//     marks that were not begun stay so.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "services/platform/link/message.h"

namespace intaglio::link {

enum class HeadFrame : std::uint8_t {
  // host -> device
  kHeadPermit = 0x50,
  kHeadBegin = 0x51,
  kHeadBlock = 0x52,
  kHeadFinish = 0x53,  ///< no payload: the run ends behind what is queued
  kHeadPause = 0x54,   ///< no payload: the run ends behind the mark in hand
  kHeadStop = 0x55,    ///< no payload: closes the shutter, ends the run at once
  kHeadReset = 0x56,   ///< no payload: leaves the safe state when its cause is gone
  kHeadPastRequest = 0x57,
  // device -> host
  kHeadIdentity = 0x60,  ///< once after every handshake
  kHeadStatus = 0x61,    ///< on every change of an interlock or of the run, every 20 ms
  kHeadMarks = 0x62,
  kHeadWeb = 0x63,
  kHeadPast = 0x64,  ///< the answer to every kHeadPastRequest
  kHeadPrint = 0x65,
};

struct HeadPermit {
  bool permitted = false;
};

/// Refused (status: run unchanged) while another run is not ended or in the safe state.
struct HeadBegin {
  std::uint32_t run = 0;  ///< greater than all before
};

/// Where a mark begins or ends: before the tick `at` of its block.
struct HeadEdge {
  std::uint16_t at = 0;  ///< 0..ticks of the block, not below the edge before
  bool begins = true;
  std::uint32_t mark = 0;
  /// Of a beginning: laser power of the largest, 0..1, and pulses, 0: continuous.
  float power_ratio = 0, frequency_hz = 0;
};

struct HeadTick {
  std::uint16_t x = 32768, y = 32768;  ///< steps of field / 2^16, 32768: centre
  bool laser = false;
};

/// In the tick first_tick + i of its block the controller adds to x
///   x_per_count * (C - (count + i * counts_per_tick)),
/// where C is the encoder's count that it expects lead_ticks after the tick's beginning,
/// by its own filter between two counts.
struct HeadFollow {
  double count = 0;  ///< that the host expected; finite, as all of these
  double counts_per_tick = 0;
  float lead_ticks = 0;   ///< 0..10000: half a tick and the lag of the mirrors
  float x_per_count = 0;  ///< steps of x, -65536..65536; 0: nothing is added
};

struct HeadBlock {
  std::uint32_t run = 0;
  std::uint64_t first_tick = 0;  ///< 0: behind what is queued
  HeadFollow follow = {};
  std::vector<HeadEdge> edges;  ///< at most kMaxHeadEdges
  std::vector<HeadTick> ticks;  ///< 1..kMaxHeadTicks
};
inline constexpr std::size_t kMaxHeadTicks = 160;
inline constexpr std::size_t kMaxHeadEdges = 16;
inline constexpr double kMaxHeadFrequency_hz = 1e8;

struct HeadPastRequest {
  std::uint32_t run = 0;
  std::uint32_t first_mark = 0;
  std::uint16_t count = 1;  ///< 1..kMaxHeadPast
};
inline constexpr std::size_t kMaxHeadPast = 512;

struct HeadIdentity {
  std::uint32_t power_up = 0;     ///< drawn at power-up: another one is another clock
  bool lockstep = false;          ///< ticks pass only as far as blocks are queued
  double rate_hz = 1e5;           ///< of ticks, 1e3..1e6
  double field_mm = 0;            ///< 1..2000
  std::uint32_t queue_ticks = 0;  ///< that it can hold, above 0
  std::uint32_t remembered_marks = 0;
  bool has_eye = false;       ///< a photo eye for print marks
  std::string model;          ///< at most 64 bytes
  std::string serial_number;  ///< printable ASCII, at most 64; empty: it has none
};

/// Of the device with this number: what a driver knows a power-up of a head by.
std::string HeadPowerUpText(const std::string& serial_number, std::uint32_t power_up);

enum HeadInterlockBits : std::uint8_t {
  kHeadKeyOn = 1 << 0,
  kHeadDoorClosed = 1 << 1,
  kHeadStopReleased = 1 << 2,
  kHeadSafeState = 1 << 3,  ///< it closed the shutter by itself, until HeadReset
  kHeadShutterOpen = 1 << 4,
  kHeadLaserOn = 1 << 5,
};

enum class HeadRunState : std::uint8_t {
  kNone = 0,         ///< no run in this session
  kOpen = 1,         ///< takes blocks
  kFinished = 2,     ///< behind its last mark
  kPaused = 3,       ///< by HeadPause
  kStopped = 4,      ///< by HeadStop or HeadPermit(0)
  kUnderrun = 5,     ///< a block came too late
  kInterlocked = 6,  ///< key, door or stop button
  kNoPermit = 7,     ///< no HeadPermit for 250 ms, or no host
  kBadBlock = 8,     ///< a mark that begins twice or ends without a beginning
  kOutside = 9,      ///< the web took a lit tick out of the field
};

struct HeadStatus {
  std::uint64_t tick = 0;
  std::uint8_t interlocks = 0;         ///< HeadInterlockBits
  std::uint16_t x = 32768, y = 32768;  ///< where the mirrors are, as in HeadTick
  std::uint32_t queued_ticks = 0;
  std::uint32_t free_ticks = 0;  ///< credit: that it can take besides those
  std::int64_t encoder_count = 0;
  float edge_mm = 0;               ///< of the web, along +y
  std::uint64_t sampled_tick = 0;  ///< when both were
  std::uint32_t openings = 0;      ///< of key, door or stop button since power-up
  std::uint32_t run = 0;           ///< the newest that it took
  HeadRunState run_state = HeadRunState::kNone;
  std::uint32_t last_begun = 0, last_done = 0;  ///< marks; kNoHeadMark: none of this run
  /// HeadPermit(0), HeadStop, HeadPause and HeadReset taken in this session.
  std::uint32_t drops_taken = 0;
  std::uint32_t prints = 0;  ///< print marks that passed the photo eye since power-up
};
inline constexpr std::uint32_t kNoHeadMark = 0xffffffff;
// The HeadMarks of all marks up to HeadStatus::tick are sent before it, and the HeadPrint
// of all print marks.

enum class HeadMarkFate : std::uint8_t {
  kBegun = 0,
  kDone = 1,
  kBroken = 2,         ///< begun, and ended before its end
  kNotBegun = 3,       ///< dropped, or never received
  kNoLongerKnown = 4,  ///< only in a HeadPast
};

struct HeadMarkEvent {
  std::uint32_t mark = 0;
  HeadMarkFate fate = HeadMarkFate::kBegun;
};

/// In order, each once.
struct HeadMarks {
  std::uint32_t run = 0;
  std::vector<HeadMarkEvent> events;  ///< 1..kMaxHeadEvents
};
inline constexpr std::size_t kMaxHeadEvents = 128;

struct HeadWebSample {
  std::int64_t encoder_count = 0;  ///< up when the web moves along +x
  float edge_mm = 0;               ///< of the web, along +y
};

/// The web at first_tick, first_tick + step_ticks, ...; none twice, none left out within
/// a session.
struct HeadWeb {
  std::uint64_t first_tick = 0;
  std::uint16_t step_ticks = 100;      ///< above 0
  std::vector<HeadWebSample> samples;  ///< 1..kMaxHeadSamples
};
inline constexpr std::size_t kMaxHeadSamples = 64;

/// A print mark whose edge has passed the photo eye.
struct HeadPrintMark {
  std::uint64_t tick = 0;  ///< in which it passed
  double count = 0;        ///< of the encoder, by the filter of HeadFollow; finite
};

/// Print marks in the order in which they passed, each once in a session; those that
/// passed before the session are left out. Sent before the HeadWeb of their time.
struct HeadPrint {
  std::uint32_t first = 0;           ///< number since power-up, from 0, of the first
  std::vector<HeadPrintMark> marks;  ///< 1..kMaxHeadPrints
};
inline constexpr std::size_t kMaxHeadPrints = 60;

struct HeadPast {
  std::uint32_t run = 0;
  std::uint32_t first_mark = 0;
  std::vector<HeadMarkFate> fates;  ///< 1..kMaxHeadPast, one a mark
};

}  // namespace intaglio::link
