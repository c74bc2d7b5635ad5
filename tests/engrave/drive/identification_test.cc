// Records are made by integrating the equation of the drive, not by the drive's own code.

#include "engrave/drive/identification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace intaglio::drive {
namespace {

/// There and back over 2 mm, sampled every 0.5 ms for 0.2 s.
std::vector<DriveSample> Record(double frequency_hz, double damping, double noise_u,
                                unsigned seed) {
  const double w = 2 * std::numbers::pi * frequency_hz, h = 1e-6, sample_s = 0.0005;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, noise_u);
  const auto command = [](double t) {
    if (t < 0.01) return 0.0;
    if (t < 0.04) return (t - 0.01) / 0.03 * 2;
    return t < 0.11 ? 2.0 : 0.5;
  };
  std::vector<DriveSample> record;
  double x = 0, v = 0;
  for (int i = 0; i < 400; ++i) {
    const double t = i * sample_s, c = command(t);
    record.push_back({t, c, x + noise(random)});
    const double slope = (command(t + sample_s) - c) / sample_s;
    for (int k = 0; k < 500; ++k) {
      const double at = c + slope * k * h;
      const double middle_x = x + h / 2 * v;
      const double middle_v = v + h / 2 * (w * w * (at - x) - 2 * damping * w * v);
      x += h * middle_v;
      v += h * (w * w * (at + slope * h / 2 - middle_x) - 2 * damping * w * middle_v);
    }
  }
  return record;
}

TEST(Identification, FindsFrequencyTo2AndDampingTo10PercentUnderNoise) {
  for (const auto& [frequency_hz, damping] :
       {std::pair(30.0, 0.1), {80.0, 0.7}, {150.0, 0.3}, {60.0, 1.5}}) {
    const auto found = Identify("second_order", Record(frequency_hz, damping, 0.005, 1));
    ASSERT_TRUE(found.has_value()) << found.error().message;
    ASSERT_EQ(found->parameters.size(), 2u);
    EXPECT_EQ(found->parameters[0].name, "natural_frequency_hz");
    EXPECT_NEAR(found->parameters[0].value, frequency_hz, 0.02 * frequency_hz);
    EXPECT_NEAR(found->parameters[1].value, damping, 0.1 * damping);
    EXPECT_NEAR(found->rms_residual_u, 0.005, 0.001);
  }
}

// The true value is outside the interval of 3 of 60 records; of more than 9 with a
// probability of 1e-3.
TEST(Identification, TheIntervalsAreThoseOfTheNoise) {
  int outside = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto found = Identify("second_order", Record(80, 0.4, 0.01, seed)).value();
    const auto& f = found.parameters[0];
    EXPECT_GT(f.interval95, 0);
    if (std::abs(f.value - 80) > f.interval95) ++outside;
  }
  EXPECT_LE(outside, 9);
}

TEST(Identification, FindsALag) {
  std::vector<DriveSample> record;
  double x = 0;
  for (int i = 0; i < 200; ++i) {
    const double t = i * 0.0005, c = i < 10 ? 0 : 1;
    record.push_back({t, c, x});
    // The command goes straight to the next sample.
    const double next = i + 1 < 10 ? 0 : 1;
    for (int k = 0; k < 1000; ++k) {
      const double h = 0.0005 / 1000;
      x += h * (c + (next - c) * (k + 0.5) / 1000 - x) / 0.003;
    }
  }
  const auto found = Identify("first_order", record).value();
  EXPECT_NEAR(found.parameters[0].value, 0.003, 3e-6);
}

TEST(Identification, RefusesWhatIsNoRecord) {
  const auto message = [](std::string_view kind, const std::vector<DriveSample>& record) {
    const auto found = Identify(kind, record);
    return found ? std::string("found") : found.error().message;
  };
  auto record = Record(80, 0.4, 0, 1);
  EXPECT_NE(message("second_order", {record.begin(), record.begin() + 5}).find("5"),
            std::string::npos);
  EXPECT_NE(message("magnet", record).find("known: first_order"), std::string::npos);
  auto twice = record;
  twice[7].time_s = twice[6].time_s;
  EXPECT_NE(message("second_order", twice).find("sample 7"), std::string::npos);
  auto nan = record;
  nan[3].position_u = std::nan("");
  EXPECT_NE(message("second_order", nan).find("sample 3"), std::string::npos);
  auto still = record;
  for (DriveSample& s : still) s.command_u = 0;
  EXPECT_NE(message("second_order", still).find("does not move"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::drive
