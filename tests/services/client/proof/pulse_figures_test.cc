#include "services/client/proof/evidence/pulse_figures.h"

#include <gtest/gtest.h>

#include <vector>

namespace intaglio::client {
namespace {

using formats::PointHistory;
using formats::PointOutcome;

PointHistory Pulse(PointOutcome outcome, float measured_mj, std::uint8_t missed = 0) {
  PointHistory point;
  point.outcome = outcome;
  point.measured_mj = measured_mj;
  point.missed_channels = missed;
  return point;
}

PulseEnergyReport EnergyOf(const std::vector<PointHistory>& history,
                           double commanded_mj) {
  JobReport report;
  AddPulseEnergies(history, {{commanded_mj}, {}}, report);
  EXPECT_EQ(report.pulse_energies_size(), 0);
  return report.pulse_energy();
}

// By hand: 29, 30, 31 and 32.5 have the mean 30.625; their deviations from it are -1.625,
// -0.625, 0.375, 1.875 with the mean square 1.671875.
TEST(PulseFigures, MeanSpreadAndTheFurthestOff) {
  const std::vector<PointHistory> history = {
      Pulse(PointOutcome::kMade, 29),      Pulse(PointOutcome::kMissed, 30),
      Pulse(PointOutcome::kMade, 0),       Pulse(PointOutcome::kMade, 31),
      Pulse(PointOutcome::kSkipped, 100),  Pulse(PointOutcome::kMade, 32.5F),
      Pulse(PointOutcome::kUncertain, 100)};
  const PulseEnergyReport report = EnergyOf(history, 30);
  EXPECT_EQ(report.commanded_mj(), 30);
  EXPECT_EQ(report.measured_count(), 4u);
  EXPECT_NEAR(report.mean_mj(), 30.625, 1e-12);
  EXPECT_NEAR(report.spread_mj(), 1.2930100541, 1e-9);
  EXPECT_EQ(report.furthest_mj(), 32.5);
  EXPECT_EQ(report.furthest_point(), 5u);
}

// A point is one of the count however many pulses make it, and a pulse that made no crack
// was fired.
TEST(PulseFigures, CountsThePulsesOfThePointsThatWereFired) {
  const std::vector<PointHistory> history = {
      Pulse(PointOutcome::kMade, 0), Pulse(PointOutcome::kMissed, 0),
      Pulse(PointOutcome::kSkipped, 0), Pulse(PointOutcome::kUncertain, 0)};
  JobReport report;
  CountPulses(history, 15, report);
  EXPECT_EQ(report.pulses_per_point(), 15);
  EXPECT_EQ(report.pulse_count(), 30);
}

TEST(PulseFigures, ALaserThatMeasuresNoneHasNoMean) {
  const std::vector<PointHistory> history = {Pulse(PointOutcome::kMade, 0)};
  const PulseEnergyReport report = EnergyOf(history, 30);
  EXPECT_EQ(report.commanded_mj(), 30);
  EXPECT_EQ(report.measured_count(), 0u);
  EXPECT_EQ(report.mean_mj(), 0);
}

TEST(PulseFigures, PointsOfSeveralEnergiesAreFiguredByTheirOwn) {
  const std::vector<PointHistory> history = {
      Pulse(PointOutcome::kMade, 5.5F), Pulse(PointOutcome::kMade, 30.5F),
      Pulse(PointOutcome::kMade, 4.5F), Pulse(PointOutcome::kMade, 31.5F),
      Pulse(PointOutcome::kMade, 0)};
  JobReport report;
  AddPulseEnergies(history, {{5, 30}, {0, 1, 0, 1, 1}}, report);
  EXPECT_FALSE(report.has_pulse_energy());
  ASSERT_EQ(report.pulse_energies_size(), 2);
  const PulseEnergyReport& low = report.pulse_energies(0);
  EXPECT_EQ(low.commanded_mj(), 5);
  EXPECT_EQ(low.measured_count(), 2u);
  EXPECT_EQ(low.mean_mj(), 5);
  EXPECT_EQ(low.spread_mj(), 0.5);
  const PulseEnergyReport& high = report.pulse_energies(1);
  EXPECT_EQ(high.commanded_mj(), 30);
  EXPECT_EQ(high.mean_mj(), 31);
  EXPECT_EQ(high.furthest_mj(), 31.5);
  EXPECT_EQ(high.furthest_point(), 3u);
}

TEST(PulseFigures, MissesAreCountedByChannel) {
  const std::vector<PointHistory> history = {
      Pulse(PointOutcome::kMissed, 30, 0b0101), Pulse(PointOutcome::kMissed, 30, 0b0100),
      Pulse(PointOutcome::kMissed, 30), Pulse(PointOutcome::kMade, 30, 0b1000)};
  JobReport report;
  AddMisses(history, report);
  ASSERT_EQ(report.missed_by_channel_size(), 2);
  EXPECT_EQ(report.missed_by_channel(0).channel(), 1u);
  EXPECT_EQ(report.missed_by_channel(0).count(), 1u);
  EXPECT_EQ(report.missed_by_channel(1).channel(), 3u);
  EXPECT_EQ(report.missed_by_channel(1).count(), 2u);
}

}  // namespace
}  // namespace intaglio::client
