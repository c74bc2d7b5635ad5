#include "services/job/machine/machine_axes.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "services/job/checks/arm_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/job_file.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr double kStageRatio = 0.65;

MachineSpec PolarProfile() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value();
}

/// els-03 with a table that moves in x and y, whose corner is under the beam at +100.
MachineSpec TableProfile() {
  MachineSpec machine = GoodMachine();
  machine.mutable_cartesian()->mutable_x()->set_moves(AXIS_MOVES_TABLE);
  machine.mutable_cartesian()->mutable_y()->set_moves(AXIS_MOVES_TABLE);
  machine.mutable_block_origin_mm()->set_x(-100);
  machine.mutable_block_origin_mm()->set_y(-100);
  return machine;
}

FrozenJob FrozenOn(const MachineSpec& machine, JobSpec job = GoodJob()) {
  FrozenJob frozen;
  *frozen.mutable_machine() = machine;
  *frozen.mutable_job() = WithDefaults(std::move(job), machine);
  frozen.mutable_optics()->set_stage_per_glass_ratio(kStageRatio);
  return frozen;
}

TEST(MachineAxes, EveryKindOfTheProfileIsOneOfTheRegistry) {
  const auto* oneof = MachineSpec::descriptor()->FindOneofByName("kinematics");
  const auto kinds = machine::KinematicsKinds();
  ASSERT_EQ(oneof->field_count(), static_cast<int>(kinds.size()));
  for (int i = 0; i < oneof->field_count(); ++i) {
    const auto* field = oneof->field(i);
    MachineSpec machine;
    machine.GetReflection()->MutableMessage(&machine, field);
    EXPECT_EQ(kinds[KinematicsOptionsOf(machine).index()].name, field->name());
  }
}

TEST(MachineAxes, OfAProfileWithoutThemAreThoseOfTheHead) {
  EXPECT_TRUE(AreHeadCoordinates(GoodMachine()));
  MachineSpec named = GoodMachine();
  named.mutable_cartesian()->mutable_z();
  EXPECT_TRUE(AreHeadCoordinates(named));
  named.mutable_cartesian()->mutable_z()->set_reversed(true);
  EXPECT_FALSE(AreHeadCoordinates(named));
  EXPECT_FALSE(AreHeadCoordinates(TableProfile()));
  EXPECT_FALSE(AreHeadCoordinates(PolarProfile()));
}

TEST(MachineAxes, ATableGoesTheOtherWay) {
  const auto axes_from_glass = AxesFromGlassOf(FrozenOn(TableProfile()));
  EXPECT_EQ(axes_from_glass.ToAxes(Vec3(10, 20, 30), Vec3::Zero()).value(),
            Vec3(90, 80, 30));
}

TEST(MachineAxes, LimitsOfAnAxisThatTurnsAreInRadians) {
  const motion::Limits limits = AxisLimitsOf(PolarProfile());
  EXPECT_EQ(limits.max_speed_mm_s, Vec3(0.8, 0.6, 80));
  EXPECT_EQ(limits.max_acceleration_mm_s2, Vec3(45, 30, 7000));
  EXPECT_EQ(limits.travel_mm.min_mm, Vec3(3.3, -12.6, -2));
}

// A job that asks for nothing gets all that the axes have; 30 mm/s are 0.2 rad/s at the
// end of the arm, and at the farthest corner of the block, 142 mm from the table's axis.
TEST(MachineAxes, SpeedOfAJobIsThatOfTheFocus) {
  EXPECT_EQ(CappedAxisLimitsOf(FrozenOn(PolarProfile())).max_speed_mm_s,
            Vec3(0.8, 0.6, 80));
  JobSpec job = GoodJob();
  job.mutable_motion()->set_max_speed_mm_s(30);
  job.mutable_motion()->set_max_acceleration_mm_s2(1500);
  const motion::Limits limits = CappedAxisLimitsOf(FrozenOn(PolarProfile(), job));
  const double farthest_mm = std::hypot(25, 140);
  EXPECT_NEAR(limits.max_speed_mm_s.x(), 0.2, 1e-12);
  EXPECT_NEAR(limits.max_speed_mm_s.y(), 30 / farthest_mm, 1e-12);
  EXPECT_EQ(limits.max_speed_mm_s.z(), 30);
  EXPECT_NEAR(limits.max_acceleration_mm_s2.x(), 10, 1e-12);
}

// By moving the axes: whatever their direction, the focus stays within the tolerance.
TEST(MachineAxes, ToleranceHoldsInTheWholeBlock) {
  const FrozenJob job = FrozenOn(PolarProfile());
  const auto axes_from_glass = AxesFromGlassOf(job);
  const double tolerance = AxisToleranceOf(job, 0.03);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  double worst_mm = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 glass_mm(50 * share(random), 50 * share(random), 30 * share(random));
    const Vec3 axes = axes_from_glass.ToAxes(glass_mm, Vec3(5, 0, 0)).value();
    const Vec3 off = Vec3(share(random) - 0.5, share(random) - 0.5, share(random) - 0.5);
    const Vec3 moved_mm =
        axes_from_glass.ToGlass(axes + tolerance * off.normalized()) - glass_mm;
    worst_mm = std::max(worst_mm, moved_mm.norm());
  }
  EXPECT_LE(worst_mm, 0.03);
  EXPECT_GT(worst_mm, 0.012) << "not ten times as strict as it has to be";
}

// The order's planner sees how fast the focus goes along x, y, z in the middle: what the
// axes do together for a small step there, and their limits, give the same.
TEST(MachineAxes, OrderFeelsTheAxesInTheGlass) {
  const FrozenJob job = FrozenOn(PolarProfile());
  const auto axes_from_glass = AxesFromGlassOf(job);
  const Vec3 own = AxisLimitsOf(job.machine()).max_speed_mm_s;
  const Vec3 middle_mm(25, 25, 15), near(5, 0, 0);
  const Vec3 speed_mm_s = OrderOptionsOf(job).limits.max_speed_mm_s;
  for (int i = 0; i < 3; ++i) {
    constexpr double kStepMm = 1e-4;
    const Vec3 step =
        (axes_from_glass.ToAxes(middle_mm + kStepMm * Vec3::Unit(i), near).value() -
         axes_from_glass.ToAxes(middle_mm, near).value()) /
        kStepMm;
    EXPECT_NEAR(speed_mm_s[i], 1 / (step.cwiseAbs().cwiseQuotient(own)).maxCoeff(),
                1e-3 * speed_mm_s[i]);
  }
}

TEST(CheckKinematics, GoodProfilesAreGood) {
  for (const MachineSpec& machine : {PolarProfile(), TableProfile()}) {
    EXPECT_THAT(CheckMachine(machine), IsEmpty());
    EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, kStageRatio), IsEmpty());
  }
}

// Trochimczuk 2008 ch. 8.1: an object of 100 mm each way, on one side of the table. Every
// place of the block is reached, and comes back from its axes.
TEST(MachineAxes, ThePolarMachineReachesABlockOf100Mm) {
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value();
  machine.mutable_block_origin_mm()->set_x(-50);
  JobSpec job = GoodJob();
  for (auto set : {&Vector3::set_x, &Vector3::set_y, &Vector3::set_z})
    (job.mutable_block()->mutable_size_mm()->*set)(100);
  EXPECT_THAT(CheckJobOnMachine(job, machine, kStageRatio), IsEmpty());
  const auto kinematics = KinematicsOf(machine);
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const Vec3 corner_mm = Vec3Of(machine.block_origin_mm());
  Vec3 near = machine::BranchStart(travel);
  for (int i = 0; i <= 20; ++i) {
    for (int j = 0; j <= 20; ++j) {
      const Vec3 place_mm = corner_mm + Vec3(5 * i, 5 * (i % 2 == 0 ? j : 20 - j), 50);
      const auto axes = kinematics->ToAxes(place_mm, near);
      ASSERT_TRUE(axes.has_value()) << place_mm.transpose();
      EXPECT_TRUE(travel.Contains(*axes)) << axes->transpose();
      EXPECT_LT((kinematics->ToPlace(*axes) - place_mm).norm(), 1e-9);
      near = *axes;
    }
  }
}

TEST(CheckKinematics, ATableNeedsTravelOnItsOwnSide) {
  MachineSpec machine = TableProfile();
  // The corner is under the beam at axis 0, so the block needs -47 to -3.
  machine.mutable_block_origin_mm()->set_x(0);
  EXPECT_THAT(
      CheckJobOnMachine(GoodJob(), machine, kStageRatio),
      ElementsAre(IsFinding("block.size_mm.x", "would have to move from -47 to -3 mm")));
}

TEST(CheckKinematics, ABlockOutOfReachOfTheArmIsNamed) {
  MachineSpec machine = PolarProfile();
  machine.mutable_block_origin_mm()->set_y(30);
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, kStageRatio),
              ElementsAre(IsFinding("block.size_mm",
                                    "is not all within the reach of polar: the "
                                    "focus at (")));
  // The nearest place, 33 mm from the table's axis, is 200 cos 0.1 -+ 26.274 mm from the
  // arm's when the arm is 0.1 rad from the line between both.
  EXPECT_THAT(
      CheckJobOnMachine(GoodJob(), machine, kStageRatio),
      ElementsAre(IsFinding("block.size_mm",
                            "; an arm of 172.727 to 225.275 mm reaches all of the "
                            "block there, polar.arm_length_mm is 150")));
  // An axis of the table inside the block is farther from every edge than the arm's
  // bound.
  machine.mutable_polar()->set_arm_length_mm(190);
  machine.mutable_block_origin_mm()->set_y(-25);
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, kStageRatio),
              ElementsAre(IsFinding("block.size_mm",
                                    "; no length of the arm reaches all of the block")));
}

TEST(CheckKinematics, TravelOfAnArmIsNamedInRadians) {
  MachineSpec machine = PolarProfile();
  machine.mutable_polar()->mutable_table()->set_travel_min_rad(-0.2);
  machine.mutable_polar()->mutable_table()->set_travel_max_rad(0.5);
  EXPECT_THAT(
      CheckJobOnMachine(GoodJob(), machine, kStageRatio),
      ElementsAre(IsFinding("block.size_mm", "the axis table would have to turn from")));
}

// The arm that the refusal names is accepted, and one that is a little shorter is not.
TEST(CheckKinematics, TheShortestArmThatIsNamedReaches) {
  for (const double y_mm : {30.0, 60.0, 230.0, 300.0}) {
    MachineSpec machine = PolarProfile();
    machine.mutable_block_origin_mm()->set_y(y_mm);
    const FrozenJob frozen = FrozenOn(machine);
    const Box3 places_mm{Vec3(-22, y_mm + 3, 0), Vec3(22, y_mm + 47, 0)};
    const auto lengths = ArmLengthsFor(machine, frozen.job(), places_mm);
    ASSERT_TRUE(lengths.has_value()) << y_mm;
    const auto found_with = [&](double arm_length_mm) {
      machine.mutable_polar()->set_arm_length_mm(arm_length_mm);
      return CheckJobOnMachine(GoodJob(), machine, kStageRatio);
    };
    EXPECT_THAT(found_with(lengths->min_mm + 0.01), IsEmpty()) << y_mm;
    EXPECT_THAT(found_with(lengths->max_mm - 0.01), IsEmpty()) << y_mm;
    EXPECT_THAT(found_with(lengths->min_mm - 0.1), testing::SizeIs(1)) << y_mm;
    EXPECT_THAT(found_with(lengths->max_mm + 0.1), testing::SizeIs(1)) << y_mm;
  }
}

TEST(ArmNotes, NameTheArmsForTwoBlocks) {
  const auto notes = ArmNotesOf(PolarProfile());
  EXPECT_THAT(
      notes,
      ElementsAre(HasSubstr("block of 50 x 50 mm at block_origin_mm: an arm of "),
                  HasSubstr("block of 100 x 100 mm at block_origin_mm: an arm of ")));
  EXPECT_THAT(notes[0], HasSubstr(" mm reaches all of the block there, "
                                  "polar.arm_length_mm is 150"));
  EXPECT_THAT(ArmNotesOf(TableProfile()), IsEmpty());
}

TEST(CheckKinematics, MistakesOfAProfileAreNamedTogether) {
  MachineSpec machine = PolarProfile();
  machine.mutable_x()->set_travel_max_mm(1);
  machine.mutable_x()->set_max_speed_mm_s(1);
  machine.mutable_x()->set_max_acceleration_mm_s2(1);
  machine.set_max_speed_norm_mm_s(80);
  PolarKinematics& polar = *machine.mutable_polar();
  polar.mutable_arm()->set_travel_max_rad(1);
  polar.clear_table();
  polar.set_arm_length_mm(0);
  polar.set_side(static_cast<ArmSide>(7));
  polar.mutable_z()->set_moves(static_cast<AxisMoves>(9));
  EXPECT_THAT(
      CheckMachine(machine),
      testing::UnorderedElementsAre(
          IsFinding("x", "remove it"), IsFinding("max_speed_norm_mm_s", "remove it"),
          IsFinding("polar.arm.travel_min_rad",
                    "3.3 is not below polar.arm.travel_max_rad, 1"),
          IsFinding("polar.table", "is missing"),
          IsFinding("polar.arm_length_mm", "0 is outside 1..10000"),
          IsFinding("polar.side", "7 is neither"),
          IsFinding("polar.z.moves", "9 is neither")));
  // Such an arm has no reach that a block could be checked against.
  EXPECT_THAT(CheckJobOnMachine(GoodJob(), machine, kStageRatio), IsEmpty());
}

}  // namespace
}  // namespace intaglio
