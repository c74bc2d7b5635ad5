#include "tests/published/screw_drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/drive/linear_drive.h"

namespace intaglio::drive {
namespace {

ScrewDrive Drive() {
  ScrewDrive d;
  d.inductance_h = 0.002;
  d.resistance_ohm = 1.2;
  d.rad_v_s = 4;
  d.gear_ratio = 0.5;
  d.metres_rad = 0.005 / (2 * std::numbers::pi);
  d.stiffness_nm_rad = 40;
  d.rotor_inertia_kg_m2 = 5e-5;
  d.screw_inertia_kg_m2 = 2e-5;
  d.table_mass_kg = 20;
  d.motor_bearing_nm_s = 1e-4;
  d.gear_bearing_nm_s = 2e-4;
  d.shaft_damping_nm_s = 1e-3;
  d.screw_bearing_nm_s = 3e-4;
  d.guide_n_s_m = 30;
  return d;
}

ScrewDriveState Along(ScrewDriveState s, const ScrewDriveState& by, double h) {
  s.motor_rad_s += h * by.motor_rad_s;
  s.table_m_s += h * by.table_m_s;
  s.shaft_torque_nm += h * by.shaft_torque_nm;
  s.current_a += h * by.current_a;
  return s;
}

ScrewDriveState Midpoint(const ScrewDrive& d, const ScrewDriveState& s, double volt,
                         double h) {
  return Along(s, SlopeOf(d, Along(s, SlopeOf(d, s, volt), h / 2), volt), h);
}

// What is not stored of the energy that the voltage gives became heat: (109)-(114)
// belong together.
TEST(ScrewDrive, EnergyIsKept) {
  const ScrewDrive d = Drive();
  ScrewDriveState s;
  double given = 0, lost = 0;
  const double h = 1e-6;
  for (int i = 0; i < 60000; ++i) {
    const double volt = i < 30000 ? 24 : -10;
    const ScrewDriveState middle = Along(s, SlopeOf(d, s, volt), h / 2);
    given += h * volt * middle.current_a;
    lost += h * LossOf(d, middle);
    s = Midpoint(d, s, volt, h);
  }
  EXPECT_GT(given, 0.5);
  EXPECT_NEAR(given, lost + EnergyOf(d, s), 1e-6 * given);
}

TEST(ScrewDrive, SettledTheTableGoesWithTheMotor) {
  const ScrewDrive d = Drive();
  ScrewDriveState s;
  for (int i = 0; i < 2000000; ++i) s = Midpoint(d, s, 24, 2e-6);
  EXPECT_NEAR(s.table_m_s, s.motor_rad_s * 0.5 * d.metres_rad, 1e-9);
  // U = R i + w / n_v1.
  EXPECT_NEAR(24, d.resistance_ohm * s.current_a + s.motor_rad_s / 4, 1e-6);
}

// The profile's drive of a stepper with these parts, against the equations with the
// current of a field that holds the rotor: the torque k (c - angle) in the place of i.
TEST(ScrewDrive, AStepperIsTheDriveOfItsParts) {
  ScrewDrive d = Drive();
  d.screw_bearing_nm_s = d.guide_n_s_m = 0;
  const StepperMotor stepper{1.2, 50, 0.05};
  const LinearDrive drive("stepper_screw", TransferOf(LoopOf(d, stepper)));
  const double per_rad = d.gear_ratio * d.metres_rad;  // table per motor angle
  const double end = 0.0001;
  ScrewDriveState s;
  double angle = 0, table = 0;
  const double h = 1e-7;
  d.motor_bearing_nm_s += stepper.damping_nm_s;
  for (int i = 0; i < 50000; ++i) {
    const auto held = [&](ScrewDriveState at, double motor_angle) {
      at.current_a = d.rad_v_s * 1.2 * 50 * (end / per_rad - motor_angle);
      return at;
    };
    const ScrewDriveState k1 = SlopeOf(d, held(s, angle), 0);
    const ScrewDriveState middle = Along(s, k1, h / 2);
    const ScrewDriveState k2 = SlopeOf(d, held(middle, angle + h / 2 * s.motor_rad_s), 0);
    angle += h * middle.motor_rad_s;
    table += h * middle.table_m_s;
    s = Along(s, k2, h);
  }
  const AxisState expected = drive.Follow(drive.SettledState({}), {end, 0, 0, 0}, 0.005);
  EXPECT_NEAR(table, expected.position_u, 1e-5 * end);
}

TEST(ScrewDrive, TheLargestAccelerationIsThatOfTheHoldingTorque) {
  const ScrewDrive d = Drive();
  const double metres = 0.5 * d.metres_rad;
  const double inertia = 5e-5 + 0.25 * 2e-5 + 20 * metres * metres;
  EXPECT_NEAR(LargestAcceleration(d, {1.2, 50, 0.05}), 1.2 / inertia * metres, 1e-12);
}

// The motor of table 4 (ch. 7.2): 160 Ncm, 1.8 degrees, 1.2 ohm, 2.2 mH, 4.1 A and
// 350 g cm2, on a screw of 5 mm with 5 kg.
TEST(ScrewDrive, TheMotorOfTheSourceHasItsFrequencyAndTheDelayOfItsCoil) {
  ScrewDrive d;
  d.inductance_h = 0.0022;
  d.resistance_ohm = 1.2;
  d.rad_v_s = 4.1 / 1.6;
  d.metres_rad = 0.005 / (2 * std::numbers::pi);
  d.stiffness_nm_rad = 40;
  d.rotor_inertia_kg_m2 = 350e-7;
  d.table_mass_kg = 5;
  const StepperMotor stepper{1.6, 50, 0.02};
  const StepperScrewLoop loop = LoopOf(d, stepper);
  EXPECT_NEAR(loop.rotor_frequency_hz, 240.6, 0.1);  // sqrt(1.6 * 50 / 350e-7) / (2 pi)
  EXPECT_NEAR(LargestAcceleration(d, stepper), 33.36, 0.01);
  // The current of a rotor at rest, in the time L / R = 1.83 ms.
  const double volt = 1.2 * 4.1;
  ScrewDriveState s;
  const double h = 0.0022 / 1.2 / 10000;
  for (int i = 0; i < 10000; ++i) {
    const double middle_a = s.current_a + h / 2 * SlopeOf(d, s, volt).current_a;
    s.current_a += h * SlopeOf(d, {0, 0, 0, middle_a}, volt).current_a;
  }
  EXPECT_NEAR(s.current_a, 4.1 * (1 - std::exp(-1)), 1e-6);
  // The printed nominal voltage does not belong to the printed current and resistance.
  EXPECT_LT(1.7 / 1.2, 1.5);
}

TEST(ScrewDrive, WhatIsNoDriveIsRefused) {
  ScrewDrive d = Drive();
  EXPECT_THROW(LoopOf(d, {1, 50, 0.01}), PreconditionError) << "the guide is damped";
  d.table_mass_kg = 0;
  EXPECT_THROW(SlopeOf(d, {}, 1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drive
