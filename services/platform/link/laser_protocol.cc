#include "services/platform/link/laser_protocol.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/platform/link/byte_codec.h"

namespace intaglio::link {
namespace {

constexpr std::size_t kMaxModelText = 64;
// Of the trigger in an ArmWindow.
constexpr std::uint8_t kGatedBit = 1, kAtPlaceBit = 2;
constexpr std::size_t kMaxLaserSerialNumber = 64;
constexpr std::size_t kMaxRates = 32;
// Of what an identity offers.
constexpr std::uint8_t kFiresAtPlaceBit = 1, kLocksDoorBit = 2;
constexpr std::uint8_t kAllShutters = 0x0f;

bool IsRate(double rate_hz) { return std::isfinite(rate_hz) && rate_hz > 0; }

tl::unexpected<Error> BadLaserFrame(const char* frame) {
  return Fail(ErrorCode::kUnreadable,
              std::string("laser line: a frame ") + frame + " is malformed", frame);
}

/// PulseReport or PastReport. A byte a tick: the outcome in the lower half, the channels
/// that missed in the upper.
template <typename Report>
void PutOutcomes(const Report& m, ByteWriter& out) {
  out.Put(m.first_tick);
  out.Put(static_cast<std::uint16_t>(m.outcome.size()));
  for (std::size_t i = 0; i < m.outcome.size(); ++i) {
    const bool unseen = m.outcome[i] == TickOutcome::kFiredUnseen;
    const unsigned missed = unseen && i < m.missed.size() ? m.missed[i] : 0;
    out.Put(static_cast<std::uint8_t>(static_cast<unsigned>(m.outcome[i]) | missed << 4));
  }
}

template <typename Report>
bool GetOutcomes(ByteReader& in, std::size_t max_ticks, TickOutcome excluded, Report& m) {
  m.first_tick = in.Get<std::uint64_t>();
  const auto count = in.Get<std::uint16_t>();
  if (!in.good() || count == 0 || count > max_ticks || GoesRound(m.first_tick, count))
    return false;
  for (int i = 0; i < count; ++i) {
    const auto byte = in.Get<std::uint8_t>();
    const auto outcome = static_cast<TickOutcome>(byte & 0x0f);
    const auto missed = static_cast<std::uint8_t>(byte >> 4);
    if (outcome > TickOutcome::kEnergyOutside || outcome == excluded ||
        (missed != 0 && outcome != TickOutcome::kFiredUnseen))
      return false;
    m.outcome.push_back(outcome);
    m.missed.push_back(missed);
  }
  return in.good();
}

bool IsEnergy(double mj) { return mj >= 0 && mj <= kMaxPulseEnergy_mj; }

}  // namespace

Bytes Encode(const LampCommand& m) {
  ByteWriter out;
  out.Put(static_cast<std::uint8_t>(m.on));
  out.Put(m.rate_hz);
  return out.Take();
}

template <>
Result<LampCommand> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  LampCommand m;
  m.on = in.GetFlag();
  m.rate_hz = in.Get<double>();
  if (!in.finished() || !std::isfinite(m.rate_hz) || m.rate_hz < 0) {
    return BadLaserFrame("LampCommand");
  }
  return m;
}

Bytes Encode(const ShutterCommand& m) {
  ByteWriter out;
  out.Put(m.open_mask);
  return out.Take();
}

template <>
Result<ShutterCommand> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  const ShutterCommand m{in.Get<std::uint8_t>()};
  if (!in.finished() || m.open_mask > kAllShutters)
    return BadLaserFrame("ShutterCommand");
  return m;
}

Bytes Encode(const ArmWindow& m) {
  ByteWriter out;
  out.Put(m.first_tick);
  out.Put(static_cast<std::uint8_t>((m.gated ? kGatedBit : 0) |
                                    (m.at_place ? kAtPlaceBit : 0)));
  out.Put(static_cast<std::uint16_t>(m.fire.size()));
  out.Put(m.pulse_energy_mj);
  for (std::size_t i = 0; i < m.fire.size(); i += 8) {
    std::uint8_t bits = 0;
    for (std::size_t j = 0; j < 8 && i + j < m.fire.size(); ++j) {
      if (m.fire[i + j]) bits = static_cast<std::uint8_t>(bits | 1u << j);
    }
    out.Put(bits);
  }
  return out.Take();
}

template <>
Result<ArmWindow> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  ArmWindow m;
  m.first_tick = in.Get<std::uint64_t>();
  const auto trigger = in.Get<std::uint8_t>();
  m.gated = (trigger & kGatedBit) != 0;
  m.at_place = (trigger & kAtPlaceBit) != 0;
  const auto count = in.Get<std::uint16_t>();
  m.pulse_energy_mj = in.Get<double>();
  if (!in.good() || !IsEnergy(m.pulse_energy_mj) || trigger > (kGatedBit | kAtPlaceBit) ||
      (m.at_place && !m.gated) || count == 0 || count > kMaxArmTicks ||
      GoesRound(m.first_tick, count)) {
    return BadLaserFrame("ArmWindow");
  }
  m.fire.resize(count);
  for (std::size_t i = 0; i < count; i += 8) {
    const auto bits = in.Get<std::uint8_t>();
    for (std::size_t j = 0; j < 8 && i + j < count; ++j)
      m.fire[i + j] = (bits >> j & 1) != 0;
    if (count - i < 8 && bits >> (count - i) != 0) return BadLaserFrame("ArmWindow");
  }
  if (!in.finished()) return BadLaserFrame("ArmWindow");
  return m;
}

Bytes Encode(const LaserIdentity& m) {
  ByteWriter out;
  out.Put(m.power_up);
  out.Put(static_cast<std::uint8_t>(m.lockstep));
  out.Put(m.channels);
  out.Put(static_cast<std::uint8_t>(std::min(m.rates_hz.size(), kMaxRates)));
  for (std::size_t i = 0; i < m.rates_hz.size() && i < kMaxRates; ++i)
    out.Put(m.rates_hz[i]);
  out.PutText(m.model, kMaxModelText);
  out.PutText(m.serial_number, kMaxLaserSerialNumber);
  out.Put(static_cast<std::uint8_t>((m.fires_at_place ? kFiresAtPlaceBit : 0) |
                                    (m.locks_door ? kLocksDoorBit : 0)));
  out.Put(m.min_energy_mj);
  out.Put(m.max_energy_mj);
  return out.Take();
}

template <>
Result<LaserIdentity> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  LaserIdentity m;
  m.power_up = in.Get<std::uint32_t>();
  m.lockstep = in.GetFlag();
  m.channels = in.Get<std::uint8_t>();
  const auto count = in.Get<std::uint8_t>();
  if (!in.good() || count > kMaxRates || m.channels < 1 || m.channels > 4) {
    return BadLaserFrame("LaserIdentity");
  }
  for (int i = 0; i < count; ++i) m.rates_hz.push_back(in.Get<double>());
  m.model = in.GetText(kMaxModelText);
  m.serial_number = in.GetPrintableText(kMaxLaserSerialNumber);
  const auto offers = in.Get<std::uint8_t>();
  m.fires_at_place = (offers & kFiresAtPlaceBit) != 0;
  m.locks_door = (offers & kLocksDoorBit) != 0;
  m.min_energy_mj = in.Get<double>();
  m.max_energy_mj = in.Get<double>();
  if (!in.finished() || offers > (kFiresAtPlaceBit | kLocksDoorBit) ||
      !IsEnergy(m.min_energy_mj) || !IsEnergy(m.max_energy_mj) ||
      m.min_energy_mj > m.max_energy_mj ||
      !std::all_of(m.rates_hz.begin(), m.rates_hz.end(), IsRate)) {
    return BadLaserFrame("LaserIdentity");
  }
  return m;
}

Bytes Encode(const LaserStatus& m) {
  ByteWriter out;
  out.Put(m.tick);
  out.Put(m.machine_us);
  out.Put(m.rate_hz);
  out.Put(m.warm_ratio);
  out.Put(m.interlocks);
  out.Put(m.shutters_open);
  out.Put(m.pulse_count);
  out.Put(m.last_fired_tick);
  out.Put(m.decided_through);
  out.Put(m.disarms_taken);
  out.Put(m.openings);
  return out.Take();
}

template <>
Result<LaserStatus> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  LaserStatus m;
  m.tick = in.Get<std::uint64_t>();
  m.machine_us = in.Get<std::uint64_t>();
  m.rate_hz = in.Get<double>();
  m.warm_ratio = in.Get<double>();
  m.interlocks = in.Get<std::uint8_t>();
  m.shutters_open = in.Get<std::uint8_t>();
  m.pulse_count = in.Get<std::uint64_t>();
  m.last_fired_tick = in.Get<std::uint64_t>();
  m.decided_through = in.Get<std::uint64_t>();
  m.disarms_taken = in.Get<std::uint32_t>();
  m.openings = in.Get<std::uint32_t>();
  if (!in.finished() || !std::isfinite(m.rate_hz) || m.rate_hz < 0 ||
      !(m.warm_ratio >= 0 && m.warm_ratio <= 1) || m.shutters_open > kAllShutters) {
    return BadLaserFrame("LaserStatus");
  }
  return m;
}

Bytes Encode(const PulseReport& m) {
  ByteWriter out;
  PutOutcomes(m, out);
  for (std::size_t i = 0; i < m.outcome.size(); ++i) {
    if (HasFired(m.outcome[i])) out.Put(i < m.measured_mj.size() ? m.measured_mj[i] : 0);
  }
  return out.Take();
}

Bytes Encode(const PastReport& m) {
  ByteWriter out;
  PutOutcomes(m, out);
  return out.Take();
}

template <>
Result<PulseReport> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  PulseReport m;
  if (!GetOutcomes(in, kMaxReportTicks, TickOutcome::kNoLongerKnown, m))
    return BadLaserFrame("PulseReport");
  for (const TickOutcome outcome : m.outcome) {
    m.measured_mj.push_back(HasFired(outcome) ? in.Get<float>() : 0);
    if (!IsEnergy(m.measured_mj.back())) return BadLaserFrame("PulseReport");
  }
  if (!in.finished()) return BadLaserFrame("PulseReport");
  return m;
}

template <>
Result<PastReport> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  PastReport m;
  if (!GetOutcomes(in, kMaxPastTicks, TickOutcome::kTooLate, m) || !in.finished())
    return BadLaserFrame("PastReport");
  return m;
}

Bytes Encode(const PastRequest& m) {
  ByteWriter out;
  out.Put(m.first_tick);
  out.Put(m.count);
  return out.Take();
}

template <>
Result<PastRequest> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  PastRequest m;
  m.first_tick = in.Get<std::uint64_t>();
  m.count = in.Get<std::uint16_t>();
  if (!in.finished() || m.count == 0 || m.count > kMaxPastTicks ||
      GoesRound(m.first_tick, m.count)) {
    return BadLaserFrame("PastRequest");
  }
  return m;
}

Bytes Encode(const PulseTiming& m) {
  ByteWriter out;
  out.Put(m.qswitch_delay_us);
  out.Put(m.qswitch_width_us);
  out.Put(m.min_sync_width_us);
  out.Put(m.min_sensor_width_us);
  out.Put(m.shutter_time_ms);
  out.Put(m.min_flash_height_mm);
  out.Put(m.max_flash_height_mm);
  return out.Take();
}

template <>
Result<PulseTiming> Decode(std::span<const std::byte> payload) {
  ByteReader in(payload);
  PulseTiming m;
  bool good = true;
  for (double* us : {&m.qswitch_delay_us, &m.qswitch_width_us, &m.min_sync_width_us,
                     &m.min_sensor_width_us}) {
    *us = in.Get<double>();
    good = good && *us >= 0 && *us <= kMaxPulseTime_us;  // false for NaN
  }
  m.shutter_time_ms = in.Get<double>();
  good = good && m.shutter_time_ms >= 0 && m.shutter_time_ms <= kMaxShutterTime_ms;
  m.min_flash_height_mm = in.Get<double>();
  m.max_flash_height_mm = in.Get<double>();
  good = good && m.min_flash_height_mm >= -kMaxFlashHeight_mm &&
         m.min_flash_height_mm <= m.max_flash_height_mm &&
         m.max_flash_height_mm <= kMaxFlashHeight_mm;
  if (!good || !in.finished()) return BadLaserFrame("PulseTiming");
  return m;
}

}  // namespace intaglio::link
