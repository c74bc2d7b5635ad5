#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>

#include <cmath>
#include <limits>

#include "services/virtual_engraver/truth/truth_check.h"
#include "services/virtual_engraver/truth/truth_file.h"
#include "services/virtual_engraver/truth_options.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  const auto truth = ParseTruth(text, "t.textproto");
  return truth ? "" : truth.error().message;
}

TEST(Truth, EveryWrongValueIsNamedAtOnce) {
  const std::string error = ErrorOf(
      "stage { travel_min_mm { x: 5 y: 0 z: 20000 } travel_max_mm { x: 5 y: 1 z: 30 }\n"
      "        second_order { natural_frequency_hz: 0.5 } clock_drift_ppm: -201\n"
      "        serial_number: 'A\\n03' }\n"
      "laser { rates_hz: [100, 0, nan] channels: 5 serial_number: '" +
      std::string(65, 'x') +
      "' }\n"
      "block { numerical_aperture: 1.2 } line_jitter_ms: inf");
  for (const char* part :
       {"t.textproto: stage.travel_min_mm.z: 20000 is outside -10000..10000\n",
        "stage.travel_min_mm.x: 5 is not below stage.travel_max_mm.x, 5\n",
        "stage.travel_min_mm.z: 20000 is not below stage.travel_max_mm.z, 30\n",
        "stage.second_order.natural_frequency_hz: 0.5 is outside 1..10000\n",
        "stage.second_order.damping_ratio: 0 is outside 0.05..5\n",
        "stage.clock_drift_ppm: -201 is outside -200..200\n",
        "stage.serial_number: \"A\\n03\" is not 0 to 64 printable ASCII characters",
        "laser.rates_hz[1]: 0 is outside 0.1..100000\n",
        "laser.rates_hz[2]: nan is outside", "laser.channels: 5 is outside 1..4\n",
        "laser.serial_number: ", "block.numerical_aperture: 1.2 is outside 0..0.95\n",
        "line_jitter_ms: inf is outside 0..2"}) {
    EXPECT_THAT(error, HasSubstr(part));
  }
}

TEST(Truth, TravelThatTheDefaultsMakeEmptyIsRefused) {
  EXPECT_THAT(ErrorOf("stage { travel_min_mm { x: 170 y: -1 z: 0 } }"),
              HasSubstr("stage.travel_min_mm.x: 170 is not below"));
  EXPECT_EQ(ErrorOf("stage { travel_min_mm { x: 169 y: -1 z: 0 } }"), "");
}

TEST(Truth, TheWaysOfItsPartsAreChecked) {
  const std::string error = ErrorOf(
      "stage { positioner { x { travel_ratio: 0 turn_rad: 1 } } backlash_um { y: -1 } }\n"
      "laser { channel_offset_mm { x: 2000 } channel_offset_mm {} channel_offset_mm {}\n"
      "  channel_offset_mm {} }");
  for (const char* part : {"stage.positioner.x.travel_ratio: 0 is outside 0.5..2",
                           "stage.positioner.x.turn_rad: 1 is outside -0.2..0.2",
                           "stage.backlash_um.y: -1 is outside 0..10000",
                           "laser.channel_offset_mm[0].x: 2000 is outside -1000..1000",
                           "laser.channel_offset_mm: 4 places are more than 3"}) {
    EXPECT_THAT(error, HasSubstr(part));
  }
}

TEST(Truth, DeviationsOfTheFieldAreASquare) {
  const auto error = [](const std::string& numbers) {
    return ErrorOf(
        "stage { positioner { mirrors { deviations { pitch_mm: 40 "
        "nodes_a_side: 2 " +
        numbers + " } } } }");
  };
  EXPECT_THAT(error("x_nm: [1, 2, 3, 4] y_nm: 1"),
              HasSubstr("stage.positioner.mirrors.deviations: 4 and 1 numbers are not "
                        "nodes_a_side squared, 4"));
  const std::string whole = "x_nm: [1, 2, 3, 4] y_nm: [0, 0, 0, 5]";
  EXPECT_EQ(error(whole), "");
  // A file in place of another replaces the whole square.
  MachineTruth truth;
  const MachineTruth changes = *ParseTruth(
      "stage { positioner { mirrors { deviations { pitch_mm: 40 "
      "nodes_a_side: 2 " +
          whole + " } } } }",
      "t");
  Replace(changes, truth);
  Replace(changes, truth);
  const auto deviations = virtual_engraver::OptionsOf(truth).positioner.deviations;
  ASSERT_EQ(deviations.values_mm.size(), 4u);
  EXPECT_EQ(deviations.values_mm[3], Vec2(4, 5) * 1e-6);
}

TEST(Truth, TooManyRatesForALineAreRefused) {
  std::string rates = "1";
  for (int i = 2; i <= 32; ++i) rates += fmt::format(", {}", i);
  EXPECT_EQ(ErrorOf("laser { rates_hz: [" + rates + "] }"), "");
  EXPECT_THAT(ErrorOf("laser { rates_hz: [" + rates + ", 33] }"),
              HasSubstr("laser.rates_hz: 33 rates are more than 32"));
}

TEST(Truth, MistakesOfSyntaxHaveTheirPlace) {
  EXPECT_THAT(ErrorOf("stage {\n  lag: 1\n}"),
              HasSubstr("t.textproto:2:6: Message type \"intaglio.TruthStage\" has no"));
  EXPECT_THAT(ErrorOf("stage { first_order_lag_s: 0 second_order { } }"),
              HasSubstr("t.textproto:1:"));
  EXPECT_THAT(ErrorOf(std::string(kMaxTruthFileBytes + 1, '#')),
              HasSubstr("larger than"));
  EXPECT_EQ(ReadTruthFile(test::FreshFolder() / "none.textproto").error().code,
            ErrorCode::kNotFound);
}

TEST(Truth, AnEmptyFileIsTheMachineOfTheDefaults) {
  using virtual_engraver::MachineOptions;
  const MachineOptions options = virtual_engraver::OptionsOf(ParseTruth("", "t").value());
  const MachineOptions plain;
  EXPECT_EQ(options.stage.travel_max_mm, plain.stage.travel_max_mm);
  EXPECT_EQ(options.stage.mechanics.lag_s, 0.0002);
  EXPECT_FALSE(options.stage.mechanics.second_order.has_value());
  EXPECT_FALSE(options.stage.own_clock.has_value());
  EXPECT_EQ(options.stage.position_tolerance_mm, 0.01);
  EXPECT_EQ(options.stage.repeatability_mm, 0);
  EXPECT_EQ(options.laser.rates_hz, std::vector<double>{100});
  EXPECT_EQ(options.laser.serial_number, "virtual-laser-1");
  EXPECT_EQ(options.block.refractive_index, 1.5);
  EXPECT_EQ(options.laser.max_energy_mj, 30);
  EXPECT_EQ(options.laser.energy_spread_ratio, 0.02);
}

TEST(Truth, EveryFieldReachesTheMachine) {
  const auto truth = ParseTruth(
      "stage { travel_min_mm { x: -1 y: -2 z: -3 } travel_max_mm { x: 1 y: 2 z: 3 }\n"
      "  second_order { natural_frequency_hz: 120 damping_ratio: 0.6 }\n"
      "  brake_acceleration_mm_s2: 5000 position_tolerance_um: 25 clock_drift_ppm: 0\n"
      "  repeatability_um: 9 serial_number: '' backlash_um { x: 7 y: 0 z: 2 }\n"
      "  steps_per_mm { x: 80 z: 400 }\n"
      "  positioner { y { travel_ratio: 1.001 turn_rad: 0.002 } } }\n"
      "laser { rates_hz: [50, 200] warm_up_s: 2 channels: 3 pulse_energy_mj: 12\n"
      "  serial_number: 'L' channel_offset_mm { x: 1 } channel_offset_mm { z: -2 } }\n"
      "block { size_mm { x: 10 y: 20 z: 30 } origin_mm { x: 4 y: 5 z: 6 }\n"
      "  refractive_index: 1.7 numerical_aperture: 0.2 }\n"
      "line_jitter_ms: 1.5 seed: 77",
      "t");
  ASSERT_TRUE(truth.has_value()) << truth.error().message;
  const auto options = virtual_engraver::OptionsOf(*truth);
  EXPECT_EQ(options.stage.travel_min_mm, Vec3(-1, -2, -3));
  EXPECT_EQ(options.stage.travel_max_mm, Vec3(1, 2, 3));
  EXPECT_EQ(options.stage.mechanics.second_order->natural_frequency_hz, 120);
  EXPECT_EQ(options.stage.mechanics.second_order->damping_ratio, 0.6);
  EXPECT_EQ(options.stage.brake_acceleration_mm_s2, 5000);
  EXPECT_EQ(options.stage.position_tolerance_mm, 0.025);
  ASSERT_TRUE(options.stage.own_clock.has_value()) << "0 ppm is a clock of its own, too";
  EXPECT_EQ(options.stage.own_clock->receive_jitter_s, 0.0015);
  EXPECT_EQ(options.stage.own_clock->seed, 77u);
  EXPECT_EQ(options.stage.repeatability_mm, 0.009);
  EXPECT_EQ(options.stage.repeatability_seed, 77u);
  EXPECT_EQ(options.stage.serial_number, "");
  EXPECT_LT((options.stage.backlash_mm - Vec3(0.007, 0, 0.002)).norm(), 1e-15);
  EXPECT_EQ(options.stage.mechanics.steps_per_mm, Vec3(80, 0, 400));
  EXPECT_EQ(options.positioner.guides[0].travel_ratio, 1);
  EXPECT_EQ(options.positioner.guides[1].travel_ratio, 1.001);
  EXPECT_EQ(options.positioner.guides[1].turn_rad, 0.002);
  EXPECT_EQ(options.channel_offset_mm[0], Vec3(0, 0, 0));
  EXPECT_EQ(options.channel_offset_mm[1], Vec3(1, 0, 0));
  EXPECT_EQ(options.channel_offset_mm[2], Vec3(0, 0, -2));
  EXPECT_EQ(options.laser.rates_hz, (std::vector<double>{50, 200}));
  EXPECT_EQ(options.laser.warm_up_s, 2);
  EXPECT_EQ(options.laser.channels, 3);
  EXPECT_EQ(options.laser.serial_number, "L");
  EXPECT_EQ(options.laser.max_energy_mj, 12);
  EXPECT_EQ(options.block.size_mm, Vec3(10, 20, 30));
  EXPECT_EQ(options.block.origin_mm, Vec3(4, 5, 6));
  EXPECT_EQ(options.block.refractive_index, 1.7);
  EXPECT_EQ(options.block.numerical_aperture, 0.2);
  EXPECT_EQ(options.line_jitter, std::chrono::microseconds(1500));
  EXPECT_EQ(options.seed, 77u);
}

TEST(Truth, ThePositionerIsThatOfTheFile) {
  const auto linear = virtual_engraver::OptionsOf(
      *ParseTruth("stage { positioner { x { carries_block: true } "
                  "z { backwards: true } } }",
                  "t"));
  EXPECT_TRUE(linear.positioner.guides[0].carries_block);
  EXPECT_FALSE(linear.positioner.guides[1].carries_block);
  EXPECT_TRUE(linear.positioner.guides[2].backwards);
  EXPECT_FALSE(linear.positioner.has_arm);
  EXPECT_EQ(linear.stage.focus_per_axis_unit_mm, Vec3(1, 1, 1));
  const auto arm = virtual_engraver::OptionsOf(
      *ParseTruth("stage { positioner { arm { pivot_distance_mm: 200 "
                  "arm_length_mm: 150 } z { carries_block: true } } }"
                  "block { origin_mm { x: -25 y: 80 } size_mm { x: 50 y: 50 z: 30 } }",
                  "t"));
  EXPECT_TRUE(arm.positioner.has_arm);
  EXPECT_EQ(arm.positioner.pivot_distance_mm, 200);
  EXPECT_EQ(arm.positioner.arm_length_mm, 150);
  EXPECT_TRUE(arm.positioner.guides[2].carries_block);
  EXPECT_EQ(arm.stage.focus_per_axis_unit_mm.x(), 150) << "a radian of the arm";
  EXPECT_FALSE(ParseTruth("stage { positioner { arm { pivot_distance_mm: 200 } } }", "t"))
      << "an arm without a length";
}

// Each drive reaches the stage with its numbers, and what a file leaves out has its
// default.
TEST(Truth, TheDriveOfAFileIsThatOfTheStage) {
  const auto loop = [](const std::string& drive) {
    const auto truth = ParseTruth("stage { " + drive + " }", "t");
    EXPECT_TRUE(truth.has_value()) << truth.error().message;
    return virtual_engraver::OptionsOf(*truth).stage.mechanics.loop.value();
  };
  const auto servo = std::get<virtual_engraver::ServoOptions>(
      loop("servo { position_gain_per_s: 150 velocity_time_s: 0.004 derivative_ratio: 1 "
           "feed_forward_ratio: 0.9 load_acceleration_mm_s2: 20 "
           "friction_acceleration_mm_s2: 30 }"));
  EXPECT_EQ(servo.position_gain_per_s, 150);
  EXPECT_EQ(servo.velocity_time_s, 0.004);
  EXPECT_EQ(servo.derivative_ratio, 1);
  EXPECT_EQ(servo.feed_forward_ratio, 0.9);
  EXPECT_EQ(servo.load_mm_s2, 20);
  EXPECT_EQ(servo.friction_mm_s2, 30);
  EXPECT_EQ(servo.max_acceleration_mm_s2, 1e6);
  const auto cascade = std::get<virtual_engraver::CascadeOptions>(loop(
      "cascade { position_gain_per_s: 90 natural_frequency_hz: 70 damping_ratio: 0.2 }"));
  EXPECT_EQ(cascade.position_gain_per_s, 90);
  EXPECT_EQ(cascade.natural_frequency_hz, 70);
  EXPECT_EQ(cascade.damping_ratio, 0.2);
  const auto stepper = std::get<virtual_engraver::StepperOptions>(
      loop("stepper_screw { rotor_frequency_hz: 80 rotor_damping_ratio: 0.3 "
           "carriage_frequency_hz: 200 carriage_damping_ratio: 0.1 inertia_ratio: 2 }"));
  EXPECT_EQ(stepper.rotor_frequency_hz, 80);
  EXPECT_EQ(stepper.inertia_ratio, 2);
  EXPECT_EQ(stepper.full_step_mm, 0.025);
  const auto planar = std::get<virtual_engraver::PlanarOptions>(
      loop("planar { natural_frequency_hz: 40 damping_ratio: 0.7 integral_rate_per_s: 9 "
           "cogging_acceleration_mm_s2: 100 sensor_error_um: 2 }"));
  EXPECT_EQ(planar.natural_frequency_hz, 40);
  EXPECT_EQ(planar.integral_rate_per_s, 9);
  EXPECT_EQ(planar.cogging_mm_s2, 100);
  EXPECT_EQ(planar.sensor_error_mm, 0.002);
  EXPECT_EQ(planar.period_s, 0.0002);
  EXPECT_EQ(planar.tooth_period_mm, 0.64);
  const auto vibration =
      virtual_engraver::OptionsOf(
          ParseTruth(
              "stage { vibration { natural_frequency_hz: 60 damping_ratio: 0.1 } }", "t")
              .value())
          .stage.vibration.value();
  EXPECT_EQ(vibration.above_mm_s2, 7500);
  EXPECT_EQ(vibration.natural_frequency_hz, 60);
  EXPECT_THAT(ErrorOf("stage { cascade { position_gain_per_s: 90 } }"),
              HasSubstr("stage.cascade.natural_frequency_hz: 0 is outside 1..10000"));
}

TEST(Truth, WhatAFileSetsReplacesTheRestStays) {
  auto truth = ParseTruth(
                   "stage { first_order_lag_s: 0.0002 position_tolerance_um: 30 }\n"
                   "laser { rates_hz: [50, 100] warm_up_s: 30 }",
                   "t")
                   .value();
  Replace(
      ParseTruth("stage { second_order { natural_frequency_hz: 90 damping_ratio: 1 } }"
                 "laser { rates_hz: 200 }",
                 "t")
          .value(),
      truth);
  EXPECT_FALSE(truth.stage().has_first_order_lag_s());
  EXPECT_EQ(truth.stage().second_order().natural_frequency_hz(), 90);
  EXPECT_EQ(truth.stage().position_tolerance_um(), 30);
  ASSERT_EQ(truth.laser().rates_hz_size(), 1);
  EXPECT_EQ(truth.laser().rates_hz(0), 200);
  EXPECT_EQ(truth.laser().warm_up_s(), 30);
}

TEST(Truth, WhatIsWrittenReadsBackTheSame) {
  const auto file = test::FreshFolder() / "truth.textproto";
  const auto truth = ParseTruth(
      "stage { first_order_lag_s: 0.1 repeatability_um: 0.3333333333333333 }", "t");
  ASSERT_TRUE(WriteTruthFile(file, *truth).has_value());
  const auto read = ReadTruthFile(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(*read, *truth));
}

TEST(Truth, TheSuppliedFilesAreGood) {
  for (const std::string name : {"els-03", "galvo"}) {
    const auto truth =
        ReadTruthFile(INTAGLIO_SOURCE_DIR "/deploy/truth/" + name + ".textproto");
    EXPECT_TRUE(truth.has_value()) << truth.error().message;
  }
}

// Trochimczuk 2008, annex D, table 10: 2 % rms. A uniform spread within s has s /
// sqrt(3).
TEST(Truth, TheSuppliedEngraverHasThePublishedStabilityOfItsEnergy) {
  const auto truth = ReadTruthFile(INTAGLIO_SOURCE_DIR "/deploy/truth/els-03.textproto");
  ASSERT_TRUE(truth.has_value()) << truth.error().message;
  const double spread_ratio =
      virtual_engraver::OptionsOf(*truth).laser.energy_spread_ratio;
  EXPECT_NEAR(spread_ratio / std::sqrt(3), 0.02, 1e-4);
}

}  // namespace
}  // namespace intaglio
