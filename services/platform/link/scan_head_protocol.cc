#include "services/platform/link/scan_head_protocol.h"

#include <fmt/format.h>

#include <cmath>

#include "services/platform/link/byte_codec.h"

namespace intaglio::link {
namespace {

constexpr std::size_t kMaxHeadText = 64;
constexpr std::uint8_t kAllHeadInterlocks = (kHeadLaserOn << 1) - 1;

tl::unexpected<Error> BadHeadFrame(const char* frame) {
  return Fail(ErrorCode::kUnreadable,
              std::string("scan head's line: a frame ") + frame + " is malformed", frame);
}

bool IsWithin(double value, double min, double max) {
  return value >= min && value <= max;  // false for NaN
}

bool GetEdge(ByteReader& in, std::size_t ticks, HeadEdge& edge) {
  const std::uint16_t before = edge.at;
  edge.at = in.Get<std::uint16_t>();
  edge.begins = in.GetFlag();
  edge.mark = in.Get<std::uint32_t>();
  edge.power_ratio = edge.frequency_hz = 0;
  if (edge.begins) {
    edge.power_ratio = in.Get<float>();
    edge.frequency_hz = in.Get<float>();
  }
  return in.good() && edge.at >= before && edge.at <= ticks && edge.mark != kNoHeadMark &&
         IsWithin(edge.power_ratio, 0, 1) &&
         IsWithin(edge.frequency_hz, 0, kMaxHeadFrequency_hz);
}

}  // namespace

std::string HeadPowerUpText(const std::string& serial_number, std::uint32_t power_up) {
  return fmt::format("{}-{:08x}", serial_number, power_up);
}

Bytes Encode(const HeadPermit& m) {
  ByteWriter out;
  out.Put(static_cast<std::uint8_t>(m.permitted));
  return out.Take();
}

template <>
Result<HeadPermit> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  const HeadPermit m{in.GetFlag()};
  if (!in.finished()) return BadHeadFrame("HeadPermit");
  return m;
}

Bytes Encode(const HeadBegin& m) {
  ByteWriter out;
  out.Put(m.run);
  return out.Take();
}

template <>
Result<HeadBegin> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  const HeadBegin m{in.Get<std::uint32_t>()};
  if (!in.finished()) return BadHeadFrame("HeadBegin");
  return m;
}

Bytes Encode(const HeadBlock& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_tick);
  out.Put(static_cast<std::uint8_t>(m.edges.size()));
  out.Put(static_cast<std::uint16_t>(m.ticks.size()));
  for (const HeadEdge& edge : m.edges) {
    out.Put(edge.at);
    out.Put(static_cast<std::uint8_t>(edge.begins));
    out.Put(edge.mark);
    if (!edge.begins) continue;
    out.Put(edge.power_ratio);
    out.Put(edge.frequency_hz);
  }
  for (const HeadTick& tick : m.ticks) {
    out.Put(tick.x);
    out.Put(tick.y);
  }
  for (std::size_t i = 0; i < m.ticks.size(); i += 8) {
    std::uint8_t bits = 0;
    for (std::size_t j = 0; j < 8 && i + j < m.ticks.size(); ++j) {
      if (m.ticks[i + j].laser) bits = static_cast<std::uint8_t>(bits | 1u << j);
    }
    out.Put(bits);
  }
  return out.Take();
}

template <>
Result<HeadBlock> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadBlock m;
  m.run = in.Get<std::uint32_t>();
  m.first_tick = in.Get<std::uint64_t>();
  const auto edges = in.Get<std::uint8_t>();
  const auto count = in.Get<std::uint16_t>();
  if (!in.good() || edges > kMaxHeadEdges || count == 0 || count > kMaxHeadTicks ||
      GoesRound(m.first_tick, count))
    return BadHeadFrame("HeadBlock");
  for (HeadEdge edge; m.edges.size() < edges;) {
    if (!GetEdge(in, count, edge)) return BadHeadFrame("HeadBlock");
    m.edges.push_back(edge);
  }
  m.ticks.resize(count);
  for (HeadTick& tick : m.ticks) {
    tick.x = in.Get<std::uint16_t>();
    tick.y = in.Get<std::uint16_t>();
  }
  for (std::size_t i = 0; i < count; i += 8) {
    const auto bits = in.Get<std::uint8_t>();
    for (std::size_t j = 0; j < 8 && i + j < count; ++j)
      m.ticks[i + j].laser = (bits >> j & 1) != 0;
    if (count - i < 8 && bits >> (count - i) != 0) return BadHeadFrame("HeadBlock");
  }
  if (!in.finished()) return BadHeadFrame("HeadBlock");
  return m;
}

Bytes Encode(const HeadPastRequest& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_mark);
  out.Put(m.count);
  return out.Take();
}

template <>
Result<HeadPastRequest> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadPastRequest m;
  m.run = in.Get<std::uint32_t>();
  m.first_mark = in.Get<std::uint32_t>();
  m.count = in.Get<std::uint16_t>();
  if (!in.finished() || m.count == 0 || m.count > kMaxHeadPast ||
      m.first_mark > kNoHeadMark - m.count)
    return BadHeadFrame("HeadPastRequest");
  return m;
}

Bytes Encode(const HeadIdentity& m) {
  ByteWriter out;
  out.Put(m.power_up);
  out.Put(static_cast<std::uint8_t>(m.lockstep));
  out.Put(m.rate_hz);
  out.Put(m.field_mm);
  out.Put(m.queue_ticks);
  out.Put(m.remembered_marks);
  out.PutText(m.model, kMaxHeadText);
  out.PutText(m.serial_number, kMaxHeadText);
  return out.Take();
}

template <>
Result<HeadIdentity> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadIdentity m;
  m.power_up = in.Get<std::uint32_t>();
  m.lockstep = in.GetFlag();
  m.rate_hz = in.Get<double>();
  m.field_mm = in.Get<double>();
  m.queue_ticks = in.Get<std::uint32_t>();
  m.remembered_marks = in.Get<std::uint32_t>();
  m.model = in.GetText(kMaxHeadText);
  m.serial_number = in.GetPrintableText(kMaxHeadText);
  if (!in.finished() || !IsWithin(m.rate_hz, 1e3, 1e6) ||
      !IsWithin(m.field_mm, 1, 2000) || m.queue_ticks == 0)
    return BadHeadFrame("HeadIdentity");
  return m;
}

Bytes Encode(const HeadStatus& m) {
  ByteWriter out;
  out.Put(m.tick);
  out.Put(m.interlocks);
  out.Put(m.x);
  out.Put(m.y);
  out.Put(m.queued_ticks);
  out.Put(m.free_ticks);
  out.Put(m.encoder_count);
  out.Put(m.edge_mm);
  out.Put(m.sampled_tick);
  out.Put(m.openings);
  out.Put(m.run);
  out.Put(static_cast<std::uint8_t>(m.run_state));
  out.Put(m.last_begun);
  out.Put(m.last_done);
  out.Put(m.drops_taken);
  return out.Take();
}

template <>
Result<HeadStatus> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadStatus m;
  m.tick = in.Get<std::uint64_t>();
  m.interlocks = in.Get<std::uint8_t>();
  m.x = in.Get<std::uint16_t>();
  m.y = in.Get<std::uint16_t>();
  m.queued_ticks = in.Get<std::uint32_t>();
  m.free_ticks = in.Get<std::uint32_t>();
  m.encoder_count = in.Get<std::int64_t>();
  m.edge_mm = in.Get<float>();
  m.sampled_tick = in.Get<std::uint64_t>();
  m.openings = in.Get<std::uint32_t>();
  m.run = in.Get<std::uint32_t>();
  m.run_state = static_cast<HeadRunState>(in.Get<std::uint8_t>());
  m.last_begun = in.Get<std::uint32_t>();
  m.last_done = in.Get<std::uint32_t>();
  m.drops_taken = in.Get<std::uint32_t>();
  if (!in.finished() || m.interlocks > kAllHeadInterlocks || !std::isfinite(m.edge_mm) ||
      m.run_state > HeadRunState::kBadBlock)
    return BadHeadFrame("HeadStatus");
  return m;
}

Bytes Encode(const HeadMarks& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(static_cast<std::uint8_t>(m.events.size()));
  for (const HeadMarkEvent& event : m.events) {
    out.Put(event.mark);
    out.Put(static_cast<std::uint8_t>(event.fate));
  }
  return out.Take();
}

template <>
Result<HeadMarks> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadMarks m;
  m.run = in.Get<std::uint32_t>();
  const auto count = in.Get<std::uint8_t>();
  if (count == 0 || count > kMaxHeadEvents) return BadHeadFrame("HeadMarks");
  for (int i = 0; i < count; ++i) {
    const auto mark = in.Get<std::uint32_t>();
    const auto fate = static_cast<HeadMarkFate>(in.Get<std::uint8_t>());
    if (fate > HeadMarkFate::kNotBegun) return BadHeadFrame("HeadMarks");
    m.events.push_back({mark, fate});
  }
  if (!in.finished()) return BadHeadFrame("HeadMarks");
  return m;
}

Bytes Encode(const HeadWeb& m) {
  ByteWriter out;
  out.Put(m.first_tick);
  out.Put(m.step_ticks);
  out.Put(static_cast<std::uint8_t>(m.samples.size()));
  for (const HeadWebSample& sample : m.samples) {
    out.Put(sample.encoder_count);
    out.Put(sample.edge_mm);
  }
  return out.Take();
}

template <>
Result<HeadWeb> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadWeb m;
  m.first_tick = in.Get<std::uint64_t>();
  m.step_ticks = in.Get<std::uint16_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || m.step_ticks == 0 || count == 0 || count > kMaxHeadSamples ||
      GoesRound(m.first_tick, std::size_t{count} * m.step_ticks))
    return BadHeadFrame("HeadWeb");
  for (int i = 0; i < count; ++i) {
    const auto encoder_count = in.Get<std::int64_t>();
    m.samples.push_back({encoder_count, in.Get<float>()});
    if (!std::isfinite(m.samples.back().edge_mm)) return BadHeadFrame("HeadWeb");
  }
  if (!in.finished()) return BadHeadFrame("HeadWeb");
  return m;
}

Bytes Encode(const HeadPast& m) {
  ByteWriter out;
  out.Put(m.run);
  out.Put(m.first_mark);
  out.Put(static_cast<std::uint16_t>(m.fates.size()));
  for (const HeadMarkFate fate : m.fates) out.Put(static_cast<std::uint8_t>(fate));
  return out.Take();
}

template <>
Result<HeadPast> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  HeadPast m;
  m.run = in.Get<std::uint32_t>();
  m.first_mark = in.Get<std::uint32_t>();
  const auto count = in.Get<std::uint16_t>();
  if (!in.good() || count == 0 || count > kMaxHeadPast ||
      m.first_mark > kNoHeadMark - count)
    return BadHeadFrame("HeadPast");
  for (int i = 0; i < count; ++i) {
    m.fates.push_back(static_cast<HeadMarkFate>(in.Get<std::uint8_t>()));
    if (m.fates.back() > HeadMarkFate::kNoLongerKnown) return BadHeadFrame("HeadPast");
  }
  if (!in.finished()) return BadHeadFrame("HeadPast");
  return m;
}

}  // namespace intaglio::link
