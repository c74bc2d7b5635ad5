#include "services/client/proof/evidence/pulse_figures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/core/channels.h"

namespace intaglio::client {

namespace {

/// Reports the points whose energy has this place in `energies`.
PulseEnergyReport PulseEnergiesOf(std::span<const formats::PointHistory> history,
                                  const PointEnergies& energies, std::uint32_t place) {
  const double commanded_mj = energies.distinct_mj[place];
  PulseEnergyReport report;
  report.set_commanded_mj(commanded_mj);
  // Deviations from what was commanded: small numbers, whose squares lose no digits.
  double sum_mj = 0, sum_of_squares_mj2 = 0, furthest_mj = -1;
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < history.size(); ++i) {
    if (energies.PlaceOf(i) != place || !formats::IsFired(history[i].outcome) ||
        !(history[i].measured_mj > 0)) {
      continue;
    }
    const double off_mj = history[i].measured_mj - commanded_mj;
    ++count;
    sum_mj += off_mj;
    sum_of_squares_mj2 += off_mj * off_mj;
    if (std::abs(off_mj) <= furthest_mj) continue;
    furthest_mj = std::abs(off_mj);
    report.set_furthest_mj(history[i].measured_mj);
    report.set_furthest_point(i);
  }
  if (count == 0) return report;
  const double mean_mj = sum_mj / static_cast<double>(count);
  const double variance =
      sum_of_squares_mj2 / static_cast<double>(count) - mean_mj * mean_mj;
  report.set_measured_count(count);
  report.set_mean_mj(commanded_mj + mean_mj);
  report.set_spread_mj(std::sqrt(std::max(0.0, variance)));
  return report;
}

}  // namespace

void AddPulseEnergies(std::span<const formats::PointHistory> history,
                      const PointEnergies& energies, JobReport& report) {
  const auto count = static_cast<std::uint32_t>(energies.distinct_mj.size());
  for (std::uint32_t place = 0; place < count; ++place) {
    PulseEnergyReport& one =
        count == 1 ? *report.mutable_pulse_energy() : *report.add_pulse_energies();
    one = PulseEnergiesOf(history, energies, place);
  }
}

void CountPulses(std::span<const formats::PointHistory> history, std::uint32_t per_point,
                 JobReport& report) {
  const auto fired = std::ranges::count_if(
      history, [](const auto& point) { return formats::IsFired(point.outcome); });
  report.set_pulses_per_point(per_point);
  report.set_pulse_count(static_cast<std::uint64_t>(fired) * per_point);
}

void AddMisses(std::span<const formats::PointHistory> history, JobReport& report) {
  std::array<std::uint64_t, kMaxChannels> counts{};
  for (const formats::PointHistory& point : history) {
    if (point.outcome != formats::PointOutcome::kMissed) continue;
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] += point.missed_channels >> i & 1;
  }
  for (std::uint32_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    ChannelMisses& misses = *report.add_missed_by_channel();
    misses.set_channel(i + 1);
    misses.set_count(counts[i]);
  }
}

}  // namespace intaglio::client
