#include "services/platform/link/motion_protocol.h"

#include <limits>

#include "services/platform/link/byte_codec.h"

namespace intaglio::link {
namespace {

constexpr std::uint8_t kPulseBit = 1, kEndBit = 2;
// Of what an identity offers.
constexpr std::uint8_t kComparesPlaceBit = 1, kWatchesAirBit = 2;
constexpr std::size_t kMaxMotionSerialNumber = 64;

tl::unexpected<Error> BadMotionFrame(const char* frame) {
  return Fail(ErrorCode::kUnreadable,
              std::string("motion line: a frame ") + frame + " is malformed", frame);
}

template <typename M>
void PutPosition(ByteWriter& out, const M& m) {
  out.Put(m.x_nm);
  out.Put(m.y_nm);
  out.Put(m.z_nm);
}

template <typename M>
void GetPosition(ByteReader& in, M& m) {
  m.x_nm = in.Get<std::int32_t>();
  m.y_nm = in.Get<std::int32_t>();
  m.z_nm = in.Get<std::int32_t>();
}

template <typename M>
void PutVelocity(ByteWriter& out, const M& m) {
  out.Put(m.vx_nm_s);
  out.Put(m.vy_nm_s);
  out.Put(m.vz_nm_s);
}

template <typename M>
void GetVelocity(ByteReader& in, M& m) {
  m.vx_nm_s = in.Get<std::int32_t>();
  m.vy_nm_s = in.Get<std::int32_t>();
  m.vz_nm_s = in.Get<std::int32_t>();
}

}  // namespace

Bytes Encode(const BeginRun& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.start_tick);
  return out.Take();
}

template <>
Result<BeginRun> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  BeginRun m;
  m.run = in.Get<std::uint32_t>();
  m.start_tick = in.Get<std::uint64_t>();
  if (!in.finished()) return BadMotionFrame("BeginRun");
  return m;
}

Bytes Encode(const Segments& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_number);
  out.Put(static_cast<std::uint8_t>(m.segments.size()));
  for (const WireSegment& segment : m.segments) {
    PutPosition(out, segment);
    PutVelocity(out, segment);
    out.Put(segment.duration_subticks);
    out.Put(static_cast<std::uint8_t>((segment.pulse ? kPulseBit : 0) |
                                      (segment.program_end ? kEndBit : 0)));
  }
  return out.Take();
}

template <>
Result<Segments> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  Segments m;
  m.run = in.Get<std::uint32_t>();
  m.first_number = in.Get<std::uint64_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || count == 0 || count > kMaxSegments ||
      GoesRound(m.first_number, count)) {
    return BadMotionFrame("Segments");
  }
  m.segments.resize(count);
  for (WireSegment& segment : m.segments) {
    GetPosition(in, segment);
    GetVelocity(in, segment);
    segment.duration_subticks = in.Get<std::uint32_t>();
    const auto flags = in.Get<std::uint8_t>();
    if (segment.duration_subticks == 0 || flags > (kPulseBit | kEndBit)) {
      return BadMotionFrame("Segments");
    }
    segment.pulse = (flags & kPulseBit) != 0;
    segment.program_end = (flags & kEndBit) != 0;
  }
  if (!in.finished()) return BadMotionFrame("Segments");
  return m;
}

Bytes Encode(const MotionIdentity& m) {
  ByteWriter out;
  for (const std::int32_t limit : m.travel_min_nm) out.Put(limit);
  for (const std::int32_t limit : m.travel_max_nm) out.Put(limit);
  out.Put(m.queue_capacity);
  out.PutText(m.serial_number, kMaxMotionSerialNumber);
  out.Put(static_cast<std::uint8_t>((m.compares_place ? kComparesPlaceBit : 0) |
                                    (m.watches_air ? kWatchesAirBit : 0)));
  return out.Take();
}

template <>
Result<MotionIdentity> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  MotionIdentity m;
  for (std::int32_t& limit : m.travel_min_nm) limit = in.Get<std::int32_t>();
  for (std::int32_t& limit : m.travel_max_nm) limit = in.Get<std::int32_t>();
  m.queue_capacity = in.Get<std::uint32_t>();
  m.serial_number = in.GetPrintableText(kMaxMotionSerialNumber);
  const auto offers = in.Get<std::uint8_t>();
  m.compares_place = (offers & kComparesPlaceBit) != 0;
  m.watches_air = (offers & kWatchesAirBit) != 0;
  if (!in.finished() || offers > (kComparesPlaceBit | kWatchesAirBit))
    return BadMotionFrame("MotionIdentity");
  return m;
}

Bytes Encode(const MotionStatus& m) {
  ByteWriter out;
  out.Put(m.tick);
  PutPosition(out, m);
  PutVelocity(out, m);
  out.Put(m.run);
  out.Put(m.covered_through_tick);
  out.Put(m.queue_free);
  out.Put(m.segments_taken);
  out.Put(static_cast<std::uint8_t>(m.at_rest));
  out.Put(static_cast<std::uint8_t>(m.fault));
  out.Put(m.following_error_max_nm);
  out.Put(m.jogs_taken);
  return out.Take();
}

template <>
Result<MotionStatus> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  MotionStatus m;
  m.tick = in.Get<std::uint64_t>();
  GetPosition(in, m);
  GetVelocity(in, m);
  m.run = in.Get<std::uint32_t>();
  m.covered_through_tick = in.Get<std::uint64_t>();
  m.queue_free = in.Get<std::uint32_t>();
  m.segments_taken = in.Get<std::uint64_t>();
  m.at_rest = in.GetFlag();
  const auto fault = in.Get<std::uint8_t>();
  m.following_error_max_nm = in.Get<std::uint32_t>();
  m.jogs_taken = in.Get<std::uint32_t>();
  if (!in.finished() || fault > static_cast<std::uint8_t>(StageFault::kAirReturned)) {
    return BadMotionFrame("MotionStatus");
  }
  m.fault = static_cast<StageFault>(fault);
  return m;
}

Bytes Encode(const Positions& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_tick);
  out.Put(static_cast<std::uint8_t>(m.positions.size()));
  for (const Positions::Position& position : m.positions) PutPosition(out, position);
  return out.Take();
}

template <>
Result<Positions> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  Positions m;
  m.run = in.Get<std::uint32_t>();
  m.first_tick = in.Get<std::uint64_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || count == 0 || count > kMaxPositions ||
      GoesRound(m.first_tick, count)) {
    return BadMotionFrame("Positions");
  }
  m.positions.resize(count);
  for (Positions::Position& position : m.positions) GetPosition(in, position);
  if (!in.finished()) return BadMotionFrame("Positions");
  return m;
}

Bytes Encode(const BeginTimedRun& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.start_ns);
  return out.Take();
}

template <>
Result<BeginTimedRun> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  BeginTimedRun m;
  m.run = in.Get<std::uint32_t>();
  m.start_ns = in.Get<std::uint64_t>();
  if (!in.finished()) return BadMotionFrame("BeginTimedRun");
  return m;
}

Bytes Encode(const TimedSegments& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_number);
  out.Put(static_cast<std::uint8_t>(m.segments.size()));
  for (const WireTimedSegment& segment : m.segments) {
    PutPosition(out, segment);
    PutVelocity(out, segment);
    out.Put(segment.end_ns);
    out.Put(static_cast<std::uint8_t>((segment.pulse ? kPulseBit : 0) |
                                      (segment.program_end ? kEndBit : 0)));
  }
  return out.Take();
}

template <>
Result<TimedSegments> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  TimedSegments m;
  m.run = in.Get<std::uint32_t>();
  m.first_number = in.Get<std::uint64_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || count == 0 || count > kMaxTimedSegments ||
      GoesRound(m.first_number, count)) {
    return BadMotionFrame("TimedSegments");
  }
  m.segments.resize(count);
  std::uint64_t before_ns = 0;
  for (WireTimedSegment& segment : m.segments) {
    GetPosition(in, segment);
    GetVelocity(in, segment);
    segment.end_ns = in.Get<std::uint64_t>();
    const auto flags = in.Get<std::uint8_t>();
    if (segment.end_ns <= before_ns || flags > (kPulseBit | kEndBit)) {
      return BadMotionFrame("TimedSegments");
    }
    before_ns = segment.end_ns;
    segment.pulse = (flags & kPulseBit) != 0;
    segment.program_end = (flags & kEndBit) != 0;
  }
  if (!in.finished()) return BadMotionFrame("TimedSegments");
  return m;
}

Bytes Encode(const TimedPositions& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_tick);
  out.Put(static_cast<std::uint8_t>(m.positions.size()));
  for (const TimedPositions::Position& position : m.positions) {
    out.Put(position.at_ns);
    PutPosition(out, position);
  }
  return out.Take();
}

template <>
Result<TimedPositions> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  TimedPositions m;
  m.run = in.Get<std::uint32_t>();
  m.first_tick = in.Get<std::uint64_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || count == 0 || count > kMaxTimedPositions ||
      GoesRound(m.first_tick, count)) {
    return BadMotionFrame("TimedPositions");
  }
  m.positions.resize(count);
  for (TimedPositions::Position& position : m.positions) {
    position.at_ns = in.Get<std::uint64_t>();
    GetPosition(in, position);
  }
  if (!in.finished()) return BadMotionFrame("TimedPositions");
  return m;
}

Bytes Encode(const ControllerClock& m) {
  ByteWriter out;
  out.Put(m.power_up);
  out.Put(m.now_ns);
  return out.Take();
}

template <>
Result<ControllerClock> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  ControllerClock m;
  m.power_up = in.Get<std::uint32_t>();
  m.now_ns = in.Get<std::uint64_t>();
  if (!in.finished() || m.power_up == 0) return BadMotionFrame("ControllerClock");
  return m;
}

Bytes Encode(const StageTolerance& m) {
  ByteWriter out;
  out.Put(m.position_nm);
  return out.Take();
}

template <>
Result<StageTolerance> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  StageTolerance m;
  m.position_nm = in.Get<std::uint32_t>();
  if (!in.finished() || m.position_nm == 0) return BadMotionFrame("StageTolerance");
  return m;
}

Bytes Encode(const JogMove& m) {
  ByteWriter out;
  PutPosition(out, m);
  out.Put(m.speed_nm_s);
  return out.Take();
}

template <>
Result<JogMove> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  JogMove m;
  GetPosition(in, m);
  m.speed_nm_s = in.Get<std::uint32_t>();
  if (!in.finished() || m.speed_nm_s == 0) return BadMotionFrame("JogMove");
  return m;
}

}  // namespace intaglio::link
