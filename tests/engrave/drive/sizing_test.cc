// Tirnovean 2016, ch. 4.1-4.3: every number of the source that is right, to 6 digits.

#include "engrave/drive/sizing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "tests/engrave/drive/tirnovean.h"

namespace intaglio::drive {
namespace {

constexpr DemandPhase kRapid = {1, 1.5}, kCut = {1, 0.25};

/// As many digits as the source prints.
void ExpectPrinted(double value, double printed, double half_digit) {
  EXPECT_NEAR(value, printed, half_digit);
}

TEST(Sizing, UnloadedAndLoadedAccelerationsAreThoseOfTheSource) {
  const auto size = SizeMotor(kSourceAxis, kSourceMotor, CylinderRule::kTirnovean2016,
                              std::array{kRapid});
  ExpectPrinted(size.unloaded.rad_s2, 2307.6923, 5e-5);       // (4.9)
  ExpectPrinted(size.unloaded.m_s2, 3.6728, 5e-5);            // (4.10)
  ExpectPrinted(size.inertia.screw_kg_m2, 14.9563e-4, 5e-9);  // (4.14)
  ExpectPrinted(size.inertia.total_kg_m2, 53.0884e-4, 5e-9);  // (4.15)
  ExpectPrinted(size.loaded.rad_s2, 1130.19, 5e-3);           // (4.16)
  ExpectPrinted(size.loaded.m_s2, 1.7987, 1e-4);              // (4.17), printed cut
}

TEST(Sizing, TorquesAreThoseOfTheSourceInItsOwnCount) {
  const TorqueDemand rapid =
      DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kTirnovean2016, kRapid);
  const TorqueDemand cut =
      DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kTirnovean2016, kCut);
  // (4.11), (4.12): printed 1.6304 and .7462; with g 9.81 to the last digit.
  ExpectPrinted(rapid.static_torque_2016_nm, 1.6304, 1e-4);
  ExpectPrinted(cut.static_torque_2016_nm, 0.7462, 1e-4);
  ExpectPrinted(rapid.angular_acceleration_rad_s2, 942.4777, 1e-4);  // (4.18)
  ExpectPrinted(cut.angular_acceleration_rad_s2, 157.0796, 5e-5);    // (4.19)
  ExpectPrinted(rapid.dynamic_torque_2016_nm, 5.0034, 1e-4);         // (4.20)
  ExpectPrinted(cut.dynamic_torque_2016_nm, 0.8339, 1e-4);           // (4.21)
  ExpectPrinted(rapid.torque_2016_nm, 6.63389, 1e-5);  // (4.22), printed cut to 6.6338
  ExpectPrinted(cut.torque_2016_nm, 1.5801, 1e-4);     // (4.23)
}

// The source has the acceleration of the mass in both parts. Counted once, with a solid
// screw: by power. The motor turns rotor, coupling and screw and pushes the mass, whose
// share costs 1 / eta.
TEST(Sizing, TheTrueDemandCountsTheMassOnce) {
  const TorqueDemand rapid =
      DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kSolid, kRapid);
  const TorqueDemand cut =
      DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kSolid, kCut);
  ExpectPrinted(rapid.torque_nm, 4.974, 5e-4);
  ExpectPrinted(cut.torque_nm, 1.304, 5e-4);
  const double metres = 0.01 / (2 * std::numbers::pi);
  const double turning = 0.26e-2 + 200e-6 + 14.9563e-4 / 2;
  const double pushing_n = 400 * (1.5 + 0.01 * 9.81);
  EXPECT_NEAR(rapid.torque_nm, turning * 1.5 / metres + pushing_n * metres / 0.9 + 0.5,
              1e-5);
  EXPECT_NEAR(rapid.current_a, rapid.torque_nm / 0.6, 1e-12);
}

// What the screw loses is lost both ways: pushing costs m a / eta, braking gives m a eta.
TEST(Sizing, BrakingGivesBackLessThanAccelerationTakes) {
  const double metres = 0.01 / (2 * std::numbers::pi);
  const auto inertia_torque = [](double a) {
    return DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kSolid, {1, a})
        .inertia_torque_nm;
  };
  EXPECT_NEAR(inertia_torque(1.5) + inertia_torque(-1.5),
              400 * 1.5 * metres * (1 / 0.9 - 0.9), 1e-9);
}

TEST(Sizing, MarginsAreOfHeatAndOfPeak) {
  // 1 s up, 1 s down, 2 s at speed.
  const std::array<DemandPhase, 3> phases = {{{1, 1.5}, {1, -1.5}, {2, 0}}};
  const auto size = SizeMotor(kSourceAxis, kSourceMotor, CylinderRule::kSolid, phases);
  double heat = 0;
  for (const DemandPhase& phase : phases) {
    const double torque =
        DemandOf(kSourceAxis, kSourceMotor, CylinderRule::kSolid, phase).torque_nm;
    heat += phase.duration_s * torque * torque / 4;
  }
  EXPECT_NEAR(size.rms_torque_nm, std::sqrt(heat), 1e-12);
  EXPECT_NEAR(size.rated_margin_ratio, 6 / std::sqrt(heat), 1e-12);
  EXPECT_NEAR(size.peak_margin_ratio, 132 / (size.peak_torque_nm / 0.6), 1e-9);
  EXPECT_GT(size.rms_current_a, 0);
}

TEST(Sizing, WhatIsNoAxisIsRefused) {
  ScrewAxis axis = kSourceAxis;
  axis.lead_m = 0;
  EXPECT_THROW(InertiaOf(axis, kSourceMotor, CylinderRule::kSolid), PreconditionError);
  EXPECT_THROW(SizeMotor(kSourceAxis, kSourceMotor, CylinderRule::kSolid, {}),
               PreconditionError);
}

TEST(Motor, TheVelocityLoopIsThatOfTheSource) {
  // (4.1)-(4.3) without their rounding: Kv w + R I over Umax.
  Amplifier amplifier = kSourceAmplifier;
  amplifier.gain_v_v = (0.2 * std::numbers::pi * 4000 / 30 + 0.18 * 10) / 10;
  const VelocityLoop loop =
      CloseVelocityLoop(kSourceMotor, amplifier, kSourceMotor.inertia_kg_m2);
  EXPECT_NEAR(loop.alpha, 0.76954, 5e-6);
  EXPECT_NEAR(loop.gain_rad_v_s, 32.923, 5e-4);
  EXPECT_NEAR(loop.motor_time_s, 0.0039, 5e-6);
  EXPECT_NEAR(loop.time_s, 0.0030, 5e-6);
  // The loaded time, 6.84 ms with a solid screw and 7.96 ms with the source's.
  const double solid =
      InertiaOf(kSourceAxis, kSourceMotor, CylinderRule::kSolid).total_kg_m2;
  const double source =
      InertiaOf(kSourceAxis, kSourceMotor, CylinderRule::kTirnovean2016).total_kg_m2;
  EXPECT_NEAR(CloseVelocityLoop(kSourceMotor, kSourceAmplifier, solid).motor_time_s,
              0.00684, 5e-6);
  EXPECT_NEAR(CloseVelocityLoop(kSourceMotor, kSourceAmplifier, source).motor_time_s,
              0.00796, 5e-6);
}

// (4.1), (4.3), (3.19), (4.36), (4.71).
TEST(Motor, TheNumbersOfThePanelAreThoseOfTheSource) {
  const double ub_v = 0.2 * std::numbers::pi * 4000 / 30 + 0.18 * 10;
  EXPECT_NEAR(ub_v, 85.57, 0.01);  // printed cut, 85.576
  EXPECT_NEAR(10 / std::pow(2, 15), kSourceVoltPerStep, 5e-9);
  EXPECT_NEAR(15000 * 10 / 24000.0 / kSourceVoltPerStep, 20480, 0.5);
  EXPECT_NEAR(2000 * 10 / 24000.0 / kSourceVoltPerStep, 2730.7, 0.1);
}

TEST(Motor, AGainCountsInItsUnit) {
  const ServoLoop pulses = SourceServo(20480, 0, PanelUnit::kEncoderPulse);
  const ServoLoop volts = SourceServo(20480, 0, PanelUnit::kVoltPerMm);
  EXPECT_NEAR(pulses.position_gain_per_s, 81870, 5);
  EXPECT_NEAR(volts.position_gain_per_s, 327.5, 0.05);
  EXPECT_NEAR(DampingRatio(pulses), 0.0315, 5e-5);
  EXPECT_NEAR(DampingRatio(volts), 0.498, 5e-4);
  EXPECT_NEAR(pulses.position_gain_per_s / volts.position_gain_per_s, 250, 1e-9);
  const ServoLoop derived = SourceServo(20480, 10, PanelUnit::kEncoderPulse);
  EXPECT_NEAR(derived.derivative_ratio, 40, 0.05);
  EXPECT_NEAR(DampingRatio(derived), 1.29, 5e-3);
}

}  // namespace
}  // namespace intaglio::drive
