#include "services/platform/link/laser_protocol.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "services/platform/link/message_fields.h"

namespace intaglio::link {
namespace {

constexpr std::size_t kMaxModelText = 64;
constexpr std::size_t kMaxLaserSerialNumber = 64;
constexpr std::size_t kMaxRates = 32;
constexpr std::uint8_t kAllShutters = 0x0f;

struct OnLaserLine {
  static constexpr const char* kLine = "laser line";
};

bool IsRate(double rate_hz) { return std::isfinite(rate_hz) && rate_hz > 0; }
bool IsRateOrZero(double rate_hz) { return std::isfinite(rate_hz) && rate_hz >= 0; }
bool IsEnergy(double mj) { return mj >= 0 && mj <= kMaxPulseEnergy_mj; }

/// The outcome in the lower half, the channels that missed in the upper.
template <typename Report>
std::uint8_t PackedOutcome(const Report& m, std::size_t i) {
  const bool unseen = m.outcome[i] == TickOutcome::kFiredUnseen;
  const unsigned missed = unseen && i < m.missed.size() ? m.missed[i] : 0;
  return static_cast<std::uint8_t>(static_cast<unsigned>(m.outcome[i]) | missed << 4);
}

/// Whether fields are read, by the type of what goes through them: a reference to it is
/// no constant expression before C++23.
template <typename Io>
constexpr bool kIsRead = std::remove_reference_t<Io>::kReads;

/// PulseReport or PastReport: a byte a tick.
void Outcomes(auto& io, auto& m, std::size_t max_ticks, TickOutcome excluded) {
  io.Number(m.first_tick);
  io.template Size<std::uint16_t>(m.outcome, 1, max_ticks);
  io.Require(!GoesRound(m.first_tick, m.outcome.size()));
  if constexpr (kIsRead<decltype(io)>) m.missed.resize(m.outcome.size());
  for (std::size_t i = 0; i < m.outcome.size(); ++i) {
    std::uint8_t byte = PackedOutcome(m, i);
    io.Number(byte);
    if constexpr (kIsRead<decltype(io)>) {
      m.outcome[i] = static_cast<TickOutcome>(byte & 0x0f);
      m.missed[i] = static_cast<std::uint8_t>(byte >> 4);
    }
    io.Require(m.outcome[i] <= TickOutcome::kEnergyOutside && m.outcome[i] != excluded &&
               (byte >> 4 == 0 || m.outcome[i] == TickOutcome::kFiredUnseen));
  }
}

}  // namespace

template <>
struct Layout<LampCommand> : OnLaserLine {
  static constexpr const char* kName = "LampCommand";
  static void Fields(auto& io, auto& m) {
    io.Flag(m.on);
    io.Number(m.rate_hz);
    io.Require(IsRateOrZero(m.rate_hz));
  }
};

template <>
struct Layout<ShutterCommand> : OnLaserLine {
  static constexpr const char* kName = "ShutterCommand";
  static void Fields(auto& io, auto& m) {
    io.Number(m.open_mask);
    io.Require(m.open_mask <= kAllShutters);
  }
};

template <>
struct Layout<ArmWindow> : OnLaserLine {
  static constexpr const char* kName = "ArmWindow";
  static void Fields(auto& io, auto& m) {
    io.Number(m.first_tick);
    io.Bits(m.gated, m.at_place);
    io.template Size<std::uint16_t>(m.fire, 1, kMaxArmTicks);
    io.Number(m.pulse_energy_mj);
    io.Number(m.pulses_per_point);
    io.Require(IsEnergy(m.pulse_energy_mj) && m.pulses_per_point <= kMaxPulsesPerPoint &&
               (m.gated || !m.at_place) && !GoesRound(m.first_tick, m.fire.size()));
    io.BitRow(m.fire.size(), [&m](std::size_t i) { return m.fire[i]; });
  }
};

template <>
struct Layout<LaserIdentity> : OnLaserLine {
  static constexpr const char* kName = "LaserIdentity";
  static void Fields(auto& io, auto& m) {
    io.Number(m.power_up);
    io.Flag(m.lockstep);
    io.Number(m.channels);
    io.Require(m.channels >= 1 && m.channels <= 4);
    io.template Size<std::uint8_t>(m.rates_hz, 0, kMaxRates);
    for (auto& rate_hz : m.rates_hz) io.Number(rate_hz);
    io.Require(std::all_of(m.rates_hz.begin(), m.rates_hz.end(), IsRate));
    io.Text(m.model, kMaxModelText);
    io.PrintableText(m.serial_number, kMaxLaserSerialNumber);
    io.Bits(m.fires_at_place, m.locks_door);
    io.Number(m.min_energy_mj);
    io.Number(m.max_energy_mj);
    io.Require(IsEnergy(m.min_energy_mj) && IsEnergy(m.max_energy_mj) &&
               m.min_energy_mj <= m.max_energy_mj);
  }
};

template <>
struct Layout<LaserStatus> : OnLaserLine {
  static constexpr const char* kName = "LaserStatus";
  static void Fields(auto& io, auto& m) {
    io.Number(m.tick);
    io.Number(m.machine_us);
    io.Number(m.rate_hz);
    io.Number(m.warm_ratio);
    io.Number(m.interlocks);
    io.Number(m.shutters_open);
    io.Number(m.pulse_count);
    io.Number(m.last_fired_tick);
    io.Number(m.decided_through);
    io.Number(m.disarms_taken);
    io.Number(m.openings);
    io.Require(IsRateOrZero(m.rate_hz) && m.warm_ratio >= 0 && m.warm_ratio <= 1 &&
               m.shutters_open <= kAllShutters);
  }
};

template <>
struct Layout<PulseReport> : OnLaserLine {
  static constexpr const char* kName = "PulseReport";
  static void Fields(auto& io, auto& m) {
    Outcomes(io, m, kMaxReportTicks, TickOutcome::kNoLongerKnown);
    if constexpr (kIsRead<decltype(io)>) m.measured_mj.resize(m.outcome.size());
    for (std::size_t i = 0; i < m.outcome.size(); ++i) {
      if (!HasFired(m.outcome[i])) continue;
      float mj = i < m.measured_mj.size() ? m.measured_mj[i] : 0;
      io.Number(mj);
      io.Require(IsEnergy(mj));
      if constexpr (kIsRead<decltype(io)>) m.measured_mj[i] = mj;
    }
  }
};

template <>
struct Layout<PastReport> : OnLaserLine {
  static constexpr const char* kName = "PastReport";
  static void Fields(auto& io, auto& m) {
    Outcomes(io, m, kMaxPastTicks, TickOutcome::kTooLate);
  }
};

template <>
struct Layout<PastRequest> : OnLaserLine {
  static constexpr const char* kName = "PastRequest";
  static void Fields(auto& io, auto& m) {
    io.Number(m.first_tick);
    io.Number(m.count);
    io.Require(m.count > 0 && m.count <= kMaxPastTicks &&
               !GoesRound(m.first_tick, m.count));
  }
};

template <>
struct Layout<PulseTiming> : OnLaserLine {
  static constexpr const char* kName = "PulseTiming";
  static void Fields(auto& io, auto& m) {
    for (auto* us : {&m.qswitch_delay_us, &m.qswitch_width_us, &m.min_sync_width_us,
                     &m.min_sensor_width_us}) {
      io.Number(*us);
      io.Require(*us >= 0 && *us <= kMaxPulseTime_us);
    }
    io.Number(m.shutter_time_ms);
    io.Require(m.shutter_time_ms >= 0 && m.shutter_time_ms <= kMaxShutterTime_ms);
    io.Number(m.min_flash_height_mm);
    io.Number(m.max_flash_height_mm);
    io.Require(m.min_flash_height_mm >= -kMaxFlashHeight_mm &&
               m.min_flash_height_mm <= m.max_flash_height_mm &&
               m.max_flash_height_mm <= kMaxFlashHeight_mm);
  }
};

template <>
struct Layout<AccessoryCommand> : OnLaserLine {
  static constexpr const char* kName = "AccessoryCommand";
  static void Fields(auto& io, auto& m) {
    io.Number(m.on);
    io.Number(m.watched);
    io.Number(m.levels);
    io.Require((m.levels & ~m.watched) == 0);
  }
};

template <>
struct Layout<AccessoryState> : OnLaserLine {
  static constexpr const char* kName = "AccessoryState";
  static void Fields(auto& io, auto& m) {
    io.Number(m.output_count);
    io.Number(m.input_count);
    io.Number(m.on);
    io.Number(m.levels);
    io.Require(m.output_count <= kMaxAccessories && m.input_count <= kMaxAccessories &&
               m.on >> m.output_count == 0 && m.levels >> m.input_count == 0);
  }
};

template Bytes Encode(const LampCommand&);
template Bytes Encode(const ShutterCommand&);
template Bytes Encode(const ArmWindow&);
template Bytes Encode(const LaserIdentity&);
template Bytes Encode(const LaserStatus&);
template Bytes Encode(const PulseReport&);
template Bytes Encode(const PastReport&);
template Bytes Encode(const PastRequest&);
template Bytes Encode(const PulseTiming&);
template Bytes Encode(const AccessoryCommand&);
template Bytes Encode(const AccessoryState&);
template Result<LampCommand> Decode(std::span<const std::byte>);
template Result<ShutterCommand> Decode(std::span<const std::byte>);
template Result<ArmWindow> Decode(std::span<const std::byte>);
template Result<LaserIdentity> Decode(std::span<const std::byte>);
template Result<LaserStatus> Decode(std::span<const std::byte>);
template Result<PulseReport> Decode(std::span<const std::byte>);
template Result<PastReport> Decode(std::span<const std::byte>);
template Result<PastRequest> Decode(std::span<const std::byte>);
template Result<PulseTiming> Decode(std::span<const std::byte>);
template Result<AccessoryCommand> Decode(std::span<const std::byte>);
template Result<AccessoryState> Decode(std::span<const std::byte>);

}  // namespace intaglio::link
