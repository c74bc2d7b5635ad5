#include "services/job/machine/head_over_block.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engrave/galvo/head_model.h"
#include "engrave/optics/focus.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_defaults.h"
#include "services/job/plan/ordering.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

MachineSpec Profile() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-glass.textproto")
      .value();
}

JobSpec CubeJob(double side_mm) {
  JobSpec job = GoodJob();
  job.clear_lens();
  job.clear_laser();
  job.clear_motion();
  job.mutable_discretization()->clear_min_spacing_mm();
  for (int axis = 0; axis < 3; ++axis) {
    Vector3& size_mm = *job.mutable_block()->mutable_size_mm();
    (axis == 0   ? size_mm.set_x(side_mm)
     : axis == 1 ? size_mm.set_y(side_mm)
                 : size_mm.set_z(side_mm));
  }
  return job;
}

FrozenJob Frozen(double side_mm) {
  FrozenJob frozen;
  *frozen.mutable_machine() = WithMachineDefaults(Profile());
  *frozen.mutable_job() = WithDefaults(CubeJob(side_mm), frozen.machine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(1.519473, 0.03));
  return frozen;
}

TEST(HeadOverBlock, TheSuppliedProfileIsGoodAndTakesACube) {
  EXPECT_THAT(CheckMachine(Profile()), IsEmpty());
  EXPECT_THAT(CheckJobOnMachine(CubeJob(60), WithMachineDefaults(Profile()), 0.658),
              IsEmpty());
}

// Its trigger has to end before the next lamp sync.
TEST(HeadOverBlock, TakesALaserOf20Kilohertz) {
  MachineSpec machine = Profile();
  machine.mutable_laser()->add_rates_hz(20'000);
  EXPECT_THAT(CheckMachine(machine),
              Contains(Field(&Error::message, HasSubstr("at 20000 Hz; reduce it"))));
  PulseTiming& timing = *machine.mutable_laser()->mutable_timing();
  timing.set_qswitch_width_us(10);
  timing.set_min_qswitch_width_us(5);
  EXPECT_THAT(CheckMachine(machine), IsEmpty());
  JobSpec job = CubeJob(60);
  job.mutable_laser()->set_rate_hz(20'000);
  EXPECT_THAT(CheckJobOnMachine(job, WithMachineDefaults(machine), 0.658), IsEmpty());
}

// Judged where the plan may be: z may move by the tolerance on its axis, and nowhere is
// the focus in the glass more than that off its depth.
TEST(HeadOverBlock, ItsPointsHaveAToleranceOfDepth) {
  FrozenJob frozen = Frozen(60);
  EXPECT_NEAR(frozen.job().motion().depth_tolerance_um(), 7.5, 1e-9) << "of 150 um";
  EXPECT_NEAR(frozen.job().ordering().sweep().slab_mm(), 0.01, 1e-12);
  EXPECT_EQ(OrderOptionsOf(frozen).method, sort::Method::kSweep);
  frozen.mutable_job()->mutable_motion()->set_depth_tolerance_um(50);
  // The order has what the plan has: under the middle, in the glass.
  EXPECT_NEAR(OrderOptionsOf(frozen).sweep.tolerance_mm,
              MotionOptionsOf(frozen).sweep_mm / frozen.optics().stage_per_glass_ratio(),
              1e-12);
  frozen.mutable_job()->mutable_ordering()->mutable_sweep()->clear_slab_mm();
  EXPECT_NEAR(WithDefaults(frozen.job(), frozen.machine()).ordering().sweep().slab_mm(),
              0.85 * 0.05, 1e-12);
  const double sweep_mm = MotionOptionsOf(frozen).sweep_mm;
  const machine::AxesFromGlass axes = AxesFromGlassOf(frozen);
  double largest_mm = 0;
  for (const double across_mm : {1.0, 15.0, 30.0, 45.0, 59.0}) {
    for (const double z_mm : {1.0, 30.0, 59.0}) {
      const Vec3 place_mm(across_mm, 60 - across_mm, z_mm);
      const Vec3 at = axes.ToAxes(place_mm, Vec3::Zero()).value();
      for (const double sign : {-1.0, 1.0}) {
        const Vec3 moved_mm = axes.ToGlass(at + sign * sweep_mm * Vec3::UnitZ());
        largest_mm = std::max(largest_mm, std::abs(moved_mm.z() - z_mm));
        EXPECT_LT((moved_mm - place_mm).head<2>().norm(), 0.001) << "hardly aside";
      }
    }
  }
  EXPECT_LE(largest_mm, 0.05 * (1 + 1e-6));
  EXPECT_GT(largest_mm, 0.9 * 0.05);
  frozen.mutable_machine()->set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  EXPECT_EQ(MotionOptionsOf(frozen).sweep_mm, 0);
}

// The ray of the commands of a place, refracted here.
TEST(HeadOverBlock, TheConeOfAPointLeansWithItsBeam) {
  const FrozenJob frozen = Frozen(60);
  const sort::BeamCone glass = PointConeOf(frozen);
  const sort::BeamCone air = PointConeInMachine(frozen);
  const optics::MachineFromGlass frame = MachineFromGlassOf(frozen);
  for (const Vec3& place_mm : {Vec3(5, 5, 5), Vec3(50, 12, 30), Vec3(30, 55, 50)}) {
    const Vec3 at = AxesFromGlassOf(frozen).ToAxes(place_mm, Vec3::Zero()).value();
    Vec3 down = Vec3(at.x() / 140, at.y() / 135, 1).normalized();
    const Vec2 across = down.head<2>() / 1.519473;
    const Vec2 slopes = across / std::sqrt(1 - across.squaredNorm());
    EXPECT_TRUE(glass.LeanAt(place_mm).isApprox(-slopes, 1e-4)) << place_mm.transpose();
    EXPECT_TRUE(air.LeanAt(frame.ToMachine(place_mm))
                    .isApprox(-slopes / frame.stage_per_glass_ratio, 1e-4));
    EXPECT_LE(slopes.norm(), glass.SteepestLean());
  }
  EXPECT_FALSE(BeamConeOf(frozen).lean->UpwardAt({5, 5, 5}).isZero());
  FrozenJob stage = frozen;
  stage.mutable_machine()->clear_head_over_block();
  EXPECT_FALSE(PointConeOf(stage).lean.has_value());
}

// The index comes back from the ratio and the aperture, the face from block and origin.
TEST(HeadOverBlock, AxesKnowTheGlassOfTheJob) {
  const FrozenJob job = Frozen(60);
  const auto axes = AxesFromGlassOf(job).ToAxes(Vec3(55, 55, 5), Vec3::Zero());
  ASSERT_TRUE(axes);
  machine::ScanHeadOptions head;
  head.lens.pupil_mm = {140, 135};
  head.refractive_index = 1.519473;
  head.top_z_mm = 60;
  const machine::AxesFromGlass expected(MachineFromGlassOf(job),
                                        machine::MakeKinematics(head));
  EXPECT_LT((*axes - *expected.ToAxes(Vec3(55, 55, 5), {})).norm(), 1e-9);
  EXPECT_NEAR(axes->x(), 24.885, 0.01);
}

FrozenJob JumpingJob() {
  FrozenJob job = Frozen(60);
  JumpAndDwell& jumps =
      *job.mutable_machine()->mutable_head_over_block()->mutable_jump_and_dwell();
  jumps.set_z_step_mm(0.066);
  jumps.set_jump_mm_s(2000);
  jumps.set_jump_delay_s(0.0002);
  jumps.set_dwell_s(0.0005);
  *job.mutable_job() = WithDefaults(CubeJob(60), job.machine());
  return job;
}

TEST(HeadOverBlock, AHeadThatJumpsIsOrderedInLayersOfZ) {
  const FrozenJob job = JumpingJob();
  EXPECT_THAT(CheckMachine(job.machine()), IsEmpty());
  EXPECT_TRUE(job.job().ordering().has_jump_layers());
  EXPECT_TRUE(Frozen(60).job().ordering().has_sweep());
  EXPECT_EQ(job.job().motion().depth_tolerance_um(), 0);
  const sort::OrderOptions options = OrderOptionsOf(job);
  EXPECT_EQ(options.method, sort::Method::kJumpLayers);
  const Vec3 deep = options.jump_layers.head_from_glass({40, 20, 10});
  const auto axes = AxesFromGlassOf(job).ToAxes({40, 20, 10}, Vec3::Zero());
  ASSERT_TRUE(axes);
  EXPECT_EQ(deep, *axes);
  EXPECT_NEAR(deep.z() / 0.066, std::round(deep.z() / 0.066), 1e-9);
  EXPECT_GT(options.jump_layers.head_from_glass({40, 20, 11}).z(), deep.z());
  // Each cone leans with its beam; none is widened to the outermost one.
  EXPECT_EQ(options.cone.tangent, job.optics().cone_tangent());
  EXPECT_TRUE(options.cone.lean);
}

// Points of one number have one energy, and no others have it.
TEST(HeadOverBlock, TheOrderOfAHeadThatJumpsKnowsTheStepsOfEnergy) {
  FrozenJob job = JumpingJob();
  job.mutable_machine()->mutable_laser()->set_pulse_energy_mj(1);
  job.mutable_job()->mutable_laser()->set_pulse_energy_mj(0.3);
  job.mutable_job()->mutable_laser()->set_wavelength_nm(532);
  const auto step_at = EnergyStepsOf(job);
  ASSERT_TRUE(step_at);
  PointList points_mm;
  for (double at_mm = 2; at_mm < 58; at_mm += 0.5)
    points_mm.emplace_back(at_mm, 30 + 0.4 * at_mm, 60 - at_mm);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  const PointEnergies energies = EnergiesOfPoints(job, points_mm, source).value();
  EXPECT_GT(energies.distinct_mj.size(), 10u);
  std::map<std::uint32_t, double> energy_of_step;
  std::set<double> seen_mj;
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const auto [found, is_new] =
        energy_of_step.emplace(step_at(points_mm[i]), energies.Of(i));
    EXPECT_EQ(found->second, energies.Of(i));
    EXPECT_EQ(seen_mj.insert(energies.Of(i)).second, is_new);
  }
  EXPECT_TRUE(host::OrderingOf(job).jump_layers.energy_from_glass);
  EXPECT_FALSE(EnergyStepsOf(Frozen(60))) << "its windows need no lists";
}

// An axis that counts downward, too, makes the deepest layer first.
TEST(HeadOverBlock, LayersBeginAtTheDeepestWhicheverWayZCounts) {
  FrozenJob job = JumpingJob();
  MachineSpec& machine = *job.mutable_machine();
  machine.mutable_head_over_block()->mutable_z()->set_moves(AXIS_MOVES_TABLE);
  machine.mutable_z()->set_travel_min_mm(-100);
  const auto head = OrderOptionsOf(job).jump_layers.head_from_glass;
  EXPECT_LT(head({30, 30, 10}).z(), head({30, 30, 11}).z());
}

TEST(HeadOverBlock, WhatAHeadThatJumpsNeedsIsNamed) {
  MachineSpec machine = Profile();
  machine.mutable_head_over_block()->mutable_jump_and_dwell()->set_jump_delay_s(1);
  machine.mutable_head_over_block()->mutable_jump_and_dwell()->set_pause_s(1);
  const auto errors = CheckMachine(machine);
  for (const char* field :
       {"z_step_mm", "jump_mm_s", "dwell_s", "jump_delay_s", "pause_after_points"}) {
    EXPECT_THAT(errors,
                Contains(Field(&Error::message,
                               HasSubstr(std::string("jump_and_dwell.") + field))));
  }
}

// Mirrors are 160 times as fast as z, and the job is not held to the limits of stages.
TEST(HeadOverBlock, MirrorsAreFastAxes) {
  const FrozenJob job = Frozen(60);
  const motion::Limits limits = CappedAxisLimitsOf(job);
  EXPECT_NEAR(limits.max_speed_mm_s.x(), 8000, 200);
  EXPECT_NEAR(limits.max_acceleration_mm_s2.y(), 2.5e7, 1e6);
  EXPECT_NEAR(limits.max_speed_mm_s.z(), 50, 1e-9);
  const motion::Limits in_glass = GlassLimitsOf(job);
  EXPECT_GT(in_glass.max_speed_mm_s.x(), 7000);
  EXPECT_NEAR(in_glass.max_speed_mm_s.z(), 50 * 1.52, 1);
}

TEST(HeadOverBlock, ABlockBeyondTheFieldIsRefused) {
  const auto findings =
      CheckJobOnMachine(CubeJob(90), WithMachineDefaults(Profile()), 0.658);
  EXPECT_THAT(findings,
              Contains(Field(&Finding::message, HasSubstr("does not fit in the field"))));
}

// The spline through the table follows the numbers; 0.1 um is far below the mirrors.
TEST(HeadOverBlock, CorrectionMakesUpForTheHead) {
  HeadOverBlockKinematics head;
  HeadNumbers& numbers = *head.mutable_correction();
  numbers.set_focal_mm(100);
  numbers.set_rotation_rad(0.01);
  numbers.set_zero_x_rad(0.002);
  numbers.set_lens_1_ratio(1.01);
  numbers.set_lens_3_ratio(0.04);
  numbers.set_offset_y_mm(0.3);
  numbers.set_shear_ratio(-0.004);
  numbers.set_axes_ratio(1.02);
  const galvo::HeadModel model = galvo::HeadModel::FromNumbers(
      100, {0.01, 0.002, 0, 1.01, 0.04, 0, 0, 0.3, -0.004, 1.02});
  const auto corrections = HeadOptionsOf(head).corrections;
  ASSERT_TRUE(corrections);
  for (double x_mm = -35; x_mm <= 35; x_mm += 3.5) {
    for (double y_mm = -35; y_mm <= 35; y_mm += 3.5) {
      const Vec2 place_mm(x_mm, y_mm);
      EXPECT_LT((model.Arrive(place_mm + corrections->At(place_mm)) - place_mm).norm(),
                1e-4)
          << place_mm.transpose();
    }
  }
}

TEST(HeadOverBlock, WrongProfilesAreRefusedWithTheirField) {
  struct Change {
    std::function<void(MachineSpec&)> make;
    const char* message;
  };
  const Change changes[] = {
      {[](MachineSpec& m) { m.mutable_head_over_block()->clear_pupil_y_mm(); },
       "head_over_block.pupil_y_mm: is missing"},
      {[](MachineSpec& m) { m.mutable_head_over_block()->set_pupil_x_mm(-3); },
       "head_over_block.pupil_x_mm: -3 is outside 10..100000"},
      {[](MachineSpec& m) { m.mutable_head_over_block()->set_crack_energy_mj(2); },
       "head_over_block.crack_energy_mj: 2 is above laser.pulse_energy_mj, 0.3"},
      {[](MachineSpec& m) {
         m.mutable_head_over_block()->mutable_correction()->set_shear_ratio(0.1);
       },
       "head_over_block.correction.focal_mm: 0 is outside 1..10000"},
      {[](MachineSpec& m) { m.clear_x(); }, "x: is missing"}};
  for (const Change& change : changes) {
    MachineSpec machine = Profile();
    change.make(machine);
    EXPECT_THAT(CheckMachine(machine),
                Contains(Field(&Error::message, HasSubstr(change.message))));
    // A job on it is refused, too, and nothing throws.
    EXPECT_FALSE(CheckAll(CubeJob(60), machine, 0.658).empty());
  }
}

}  // namespace
}  // namespace intaglio
