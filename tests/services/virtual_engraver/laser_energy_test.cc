// The energy of the laser's pulses, and what its photosensors report of each channel.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "services/virtual_engraver/laser.h"

namespace intaglio::virtual_engraver {
namespace {

using link::TickOutcome;

/// Warm with the lamp.
LaserOptions FourChannels() {
  LaserOptions options;
  options.warm_up_s = 0;
  options.channels = 4;
  options.min_energy_mj = 0;  // windows without an energy fire
  return options;
}

// Trochimczuk 2008, annex D, table 10: 2 %; another seed draws other energies.
TEST(LaserEnergy, IsAsCommandedWithinTheSpreadAndMeasured) {
  LaserOptions options = FourChannels();
  for (const double error_ratio : {0.0, -0.1}) {
    options.energy_error_ratio = error_ratio;
    Laser laser(options);
    laser.SetLamp({true, 100});
    laser.SetShutters(1);
    double sum_mj = 0, min_mj = 1e9, max_mj = 0;
    constexpr int kPulses = 2000;
    laser.Decide({1, false, std::vector<bool>(kPulses, true), false, 12});
    std::vector<float> fired_mj;
    for (int i = 0; i < kPulses; ++i) {
      ASSERT_EQ(laser.AdvanceTick(false), 1);
      const double mj = laser.pulse_energy_mj();
      fired_mj.push_back(static_cast<float>(mj));
      sum_mj += mj;
      min_mj = std::min(min_mj, mj);
      max_mj = std::max(max_mj, mj);
    }
    const double true_mj = 12 * (1 + error_ratio);
    EXPECT_GE(min_mj, true_mj * 0.98);
    EXPECT_LE(max_mj, true_mj * 1.02);
    // A uniform spread: its ends are nearly reached, and its mean deviates by about
    // 0.02 / sqrt(3 * 2000) of the energy, of which this is five times.
    EXPECT_LT(min_mj, true_mj * 0.981);
    EXPECT_GT(max_mj, true_mj * 1.019);
    EXPECT_NEAR(sum_mj / kPulses, true_mj, true_mj * 0.0013);
    std::vector<float> measured_mj;
    for (const link::PulseReport& report : laser.TakeReports())
      measured_mj.insert(measured_mj.end(), report.measured_mj.begin(),
                         report.measured_mj.end());
    EXPECT_EQ(measured_mj, fired_mj);
  }
}

TEST(LaserEnergy, OutsideTheRangeMakesNoPulseAndIsReported) {
  LaserOptions options = FourChannels();
  options.min_energy_mj = 2;
  options.max_energy_mj = 30;
  for (const double mj :
       {0.0, 1.99, 2.0, 30.0, 30.01, -5.0, std::numeric_limits<double>::quiet_NaN()}) {
    Laser laser(options);
    laser.SetLamp({true, 100});
    for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
    laser.SetShutters(1);
    laser.Decide({11, false, {true}, false, mj});
    const bool inside = mj >= 2 && mj <= 30;
    EXPECT_EQ(laser.AdvanceTick(false) != 0, inside) << mj;
    EXPECT_EQ(laser.Report().pulse_count, inside ? 1u : 0u) << mj;
    EXPECT_EQ(laser.TakeReports().at(0).outcome.at(0),
              inside ? TickOutcome::kFiredSeen : TickOutcome::kEnergyOutside)
        << mj;
  }
}

TEST(LaserSensor, AMissNamesItsChannelAlsoInTheMemory) {
  Laser laser(FourChannels());
  laser.SetLamp({true, 100});
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  laser.SetShutters(0b0101);
  laser.Decide({11, false, {true, true, true}});
  EXPECT_EQ(laser.AdvanceTick(false), 0b0101);
  laser.Missed(0b1100);  // 4 is not open
  laser.AdvanceTick(false);
  laser.Missed(0b1010);
  laser.AdvanceTick(false);
  laser.Missed(0b0101);
  const auto reports = laser.TakeReports();
  ASSERT_EQ(reports.size(), 1u);
  const std::vector outcomes = {TickOutcome::kFiredUnseen, TickOutcome::kFiredSeen,
                                TickOutcome::kFiredUnseen};
  EXPECT_EQ(reports[0].outcome, outcomes);
  EXPECT_EQ(reports[0].missed, (std::vector<std::uint8_t>{0b0100, 0, 0b0101}));
  const link::PastReport past = laser.Past({11, 3});
  EXPECT_EQ(past.outcome, outcomes);
  EXPECT_EQ(past.missed, (std::vector<std::uint8_t>{0b0100, 0, 0b0101}));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
