#include "services/platform/link/scan_head_protocol.h"

#include <fmt/format.h>

#include <cmath>

#include "services/platform/link/message_fields.h"

namespace intaglio::link {
namespace {

constexpr std::size_t kMaxHeadText = 64;
constexpr std::uint8_t kAllHeadInterlocks = (kHeadLaserOn << 1) - 1;

struct OnHeadLine {
  static constexpr const char* kLine = "scan head's line";
};

bool IsWithin(double value, double min, double max) {
  return value >= min && value <= max;  // false for NaN
}

/// `before`: the tick of the edge before it; `ticks`: of the block.
void Edge(auto& io, auto& edge, std::uint16_t before, std::size_t ticks) {
  io.Number(edge.at);
  io.Flag(edge.begins);
  io.Number(edge.mark);
  if (edge.begins) {
    io.Number(edge.power_ratio);
    io.Number(edge.frequency_hz);
  }
  io.Require(edge.at >= before && edge.at <= ticks && edge.mark != kNoHeadMark &&
             IsWithin(edge.power_ratio, 0, 1) &&
             IsWithin(edge.frequency_hz, 0, kMaxHeadFrequency_hz));
}

void Follow(auto& io, auto& follow) {
  io.Number(follow.count);
  io.Number(follow.counts_per_tick);
  io.Number(follow.lead_ticks);
  io.Number(follow.x_per_count);
  io.Require(std::isfinite(follow.count) && std::isfinite(follow.counts_per_tick) &&
             IsWithin(follow.lead_ticks, 0, 1e4) &&
             IsWithin(follow.x_per_count, -65536, 65536));
}

}  // namespace

std::string HeadPowerUpText(const std::string& serial_number, std::uint32_t power_up) {
  return fmt::format("{}-{:08x}", serial_number, power_up);
}

template <>
struct Layout<HeadPermit> : OnHeadLine {
  static constexpr const char* kName = "HeadPermit";
  static void Fields(auto& io, auto& m) { io.Flag(m.permitted); }
};

template <>
struct Layout<HeadBegin> : OnHeadLine {
  static constexpr const char* kName = "HeadBegin";
  static void Fields(auto& io, auto& m) { io.Number(m.run); }
};

template <>
struct Layout<HeadBlock> : OnHeadLine {
  static constexpr const char* kName = "HeadBlock";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.Number(m.first_tick);
    Follow(io, m.follow);
    io.template Size<std::uint8_t>(m.edges, 0, kMaxHeadEdges);
    io.template Size<std::uint16_t>(m.ticks, 1, kMaxHeadTicks);
    io.Require(!GoesRound(m.first_tick, m.ticks.size()));
    std::uint16_t before = 0;
    for (auto& edge : m.edges) {
      Edge(io, edge, before, m.ticks.size());
      before = edge.at;
    }
    for (auto& tick : m.ticks) {
      io.Number(tick.x);
      io.Number(tick.y);
    }
    io.BitRow(
        m.ticks.size(), [&m](std::size_t i) -> auto& { return m.ticks[i].laser; });
  }
};

template <>
struct Layout<HeadPastRequest> : OnHeadLine {
  static constexpr const char* kName = "HeadPastRequest";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.Number(m.first_mark);
    io.Number(m.count);
    io.Require(m.count > 0 && m.count <= kMaxHeadPast &&
               m.first_mark <= kNoHeadMark - m.count);
  }
};

template <>
struct Layout<HeadIdentity> : OnHeadLine {
  static constexpr const char* kName = "HeadIdentity";
  static void Fields(auto& io, auto& m) {
    io.Number(m.power_up);
    io.Flag(m.lockstep);
    io.Number(m.rate_hz);
    io.Number(m.field_mm);
    io.Number(m.queue_ticks);
    io.Number(m.remembered_marks);
    io.Flag(m.has_eye);
    io.Text(m.model, kMaxHeadText);
    io.PrintableText(m.serial_number, kMaxHeadText);
    io.Require(IsWithin(m.rate_hz, 1e3, 1e6) && IsWithin(m.field_mm, 1, 2000) &&
               m.queue_ticks > 0);
  }
};

template <>
struct Layout<HeadStatus> : OnHeadLine {
  static constexpr const char* kName = "HeadStatus";
  static void Fields(auto& io, auto& m) {
    io.Number(m.tick);
    io.Number(m.interlocks);
    io.Number(m.x);
    io.Number(m.y);
    io.Number(m.queued_ticks);
    io.Number(m.free_ticks);
    io.Number(m.encoder_count);
    io.Number(m.edge_mm);
    io.Number(m.sampled_tick);
    io.Number(m.openings);
    io.Number(m.run);
    io.Enumerator(m.run_state, HeadRunState::kOutside);
    io.Number(m.last_begun);
    io.Number(m.last_done);
    io.Number(m.drops_taken);
    io.Number(m.prints);
    io.Require(m.interlocks <= kAllHeadInterlocks && std::isfinite(m.edge_mm));
  }
};

template <>
struct Layout<HeadMarks> : OnHeadLine {
  static constexpr const char* kName = "HeadMarks";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.template Size<std::uint8_t>(m.events, 1, kMaxHeadEvents);
    for (auto& event : m.events) {
      io.Number(event.mark);
      io.Enumerator(event.fate, HeadMarkFate::kNotBegun);
    }
  }
};

template <>
struct Layout<HeadWeb> : OnHeadLine {
  static constexpr const char* kName = "HeadWeb";
  static void Fields(auto& io, auto& m) {
    io.Number(m.first_tick);
    io.Number(m.step_ticks);
    io.template Size<std::uint8_t>(m.samples, 1, kMaxHeadSamples);
    io.Require(m.step_ticks > 0 &&
               !GoesRound(m.first_tick, m.samples.size() * m.step_ticks));
    for (auto& sample : m.samples) {
      io.Number(sample.encoder_count);
      io.Number(sample.edge_mm);
      io.Require(std::isfinite(sample.edge_mm));
    }
  }
};

template <>
struct Layout<HeadPrint> : OnHeadLine {
  static constexpr const char* kName = "HeadPrint";
  static void Fields(auto& io, auto& m) {
    io.Number(m.first);
    io.template Size<std::uint8_t>(m.marks, 1, kMaxHeadPrints);
    io.Require(m.first <= 0xffffffff - m.marks.size());
    for (auto& mark : m.marks) {
      io.Number(mark.tick);
      io.Number(mark.count);
      io.Require(std::isfinite(mark.count));
    }
  }
};

template <>
struct Layout<HeadPast> : OnHeadLine {
  static constexpr const char* kName = "HeadPast";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.Number(m.first_mark);
    io.template Size<std::uint16_t>(m.fates, 1, kMaxHeadPast);
    io.Require(m.first_mark <= kNoHeadMark - m.fates.size());
    for (auto& fate : m.fates) io.Enumerator(fate, HeadMarkFate::kNoLongerKnown);
  }
};

template Bytes Encode(const HeadPermit&);
template Bytes Encode(const HeadBegin&);
template Bytes Encode(const HeadBlock&);
template Bytes Encode(const HeadPastRequest&);
template Bytes Encode(const HeadIdentity&);
template Bytes Encode(const HeadStatus&);
template Bytes Encode(const HeadMarks&);
template Bytes Encode(const HeadWeb&);
template Bytes Encode(const HeadPrint&);
template Bytes Encode(const HeadPast&);
template Result<HeadPermit> Decode(std::span<const std::byte>);
template Result<HeadBegin> Decode(std::span<const std::byte>);
template Result<HeadBlock> Decode(std::span<const std::byte>);
template Result<HeadPastRequest> Decode(std::span<const std::byte>);
template Result<HeadIdentity> Decode(std::span<const std::byte>);
template Result<HeadStatus> Decode(std::span<const std::byte>);
template Result<HeadMarks> Decode(std::span<const std::byte>);
template Result<HeadWeb> Decode(std::span<const std::byte>);
template Result<HeadPrint> Decode(std::span<const std::byte>);
template Result<HeadPast> Decode(std::span<const std::byte>);

}  // namespace intaglio::link
