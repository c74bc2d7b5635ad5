#include "services/job/machine/head_clearance.h"

#include <gmock/gmock.h>

#include "engrave/optics/focus.h"
#include "services/job/checks/head_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNbk7 = 1.51947;

/// els-03 with a block of this height, in N-BK7, with the lens of this focal length.
FrozenJob JobOf(double height_mm, double focal_length_mm = 43,
                MachineSpec machine = GoodMachine()) {
  FrozenJob job;
  *job.mutable_machine() = WithMachineDefaults(std::move(machine));
  JobSpec spec = GoodJob();
  spec.mutable_block()->mutable_size_mm()->set_z(height_mm);
  spec.mutable_lens()->set_focal_length_mm(focal_length_mm);
  *job.mutable_job() = WithDefaults(spec, job.machine());
  const double aperture = job.job().lens().numerical_aperture();
  job.mutable_optics()->set_refractive_index(kNbk7);
  job.mutable_optics()->set_numerical_aperture(aperture);
  job.mutable_optics()->set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(kNbk7, aperture));
  return job;
}

std::string RefusalOf(const FrozenJob& job, const PointList& points_mm,
                      PointOrder order = PointOrder::kOfEngraving) {
  const Status status = CheckHeadClearance(job, points_mm, order);
  if (status) return "";
  EXPECT_EQ(status.error().code, ErrorCode::kOutsideBlock);
  return status.error().message;
}

// Trochimczuk 2008 annex D: objects of over 60 mm, blocks of over 100 mm.
TEST(HeadClearance, OfThePublishedLensesIsThatOfTheSource) {
  const FrozenJob f43 = JobOf(170), f70 = JobOf(170, 70);
  EXPECT_EQ(RefusalOf(f43, {Vec3(25, 25, 170 - 65.2)}), "");
  EXPECT_THAT(RefusalOf(f43, {Vec3(25, 25, 170 - 65.6)}), HasSubstr("the lens f43"));
  EXPECT_EQ(RefusalOf(f70, {Vec3(25, 25, 170 - 106.2)}), "");
  EXPECT_THAT(RefusalOf(f70, {Vec3(25, 25, 170 - 106.6)}), HasSubstr("the lens f70"));
}

// What admission compares heights with, before there are points, is the same rule.
TEST(HeadClearance, BeginsToRefusePointsWhereTheLensReachesNoFurther) {
  for (const double focal_length_mm : {43, 70}) {
    for (const double free_mm : {0, 30}) {
      MachineSpec machine = GoodMachine();
      for (MachineLens& lens : *machine.mutable_lenses())
        if (free_mm > 0) lens.set_free_distance_mm(free_mm);
      const FrozenJob job = JobOf(170, focal_length_mm, machine);
      const double reach_mm = ReachMm(*FindLens(job.machine(), focal_length_mm),
                                      job.optics().stage_per_glass_ratio());
      EXPECT_EQ(RefusalOf(job, {Vec3(25, 25, 170 - reach_mm + 1e-3)}), "");
      EXPECT_THAT(RefusalOf(job, {Vec3(25, 25, 170 - reach_mm - 1e-3)}),
                  HasSubstr("the lens f"));
    }
  }
}

TEST(HeadClearance, TheMessageHasWhatWhereHowMuchWhyAndTheRemedy) {
  const std::string refusal =
      RefusalOf(JobOf(100), {Vec3(25, 25, 90), Vec3(24, 23, 5), Vec3(25, 25, 30)});
  EXPECT_THAT(refusal,
              AllOf(HasSubstr("2 of 3 points would bring the head into the block"),
                    HasSubstr("at point (24, 23, 5) mm, 95.0 mm below the top face"),
                    HasSubstr("the lens f43 would be 19.5 mm inside the block"),
                    HasSubstr("has no free_distance_mm"), HasSubstr("43 mm above"),
                    HasSubstr("take the lens f70, which reaches 106.")));
  MachineSpec machine = GoodMachine();
  machine.mutable_lenses(0)->set_free_distance_mm(30);
  EXPECT_THAT(RefusalOf(JobOf(100, 43, machine), {Vec3(25, 25, 50)}),
              AllOf(HasSubstr("2.9 mm inside the block"),
                    HasSubstr("30 mm above its focus in air, free_distance_mm")));
}

TEST(HeadClearance, AFixtureIsNamedAndOnlyWhereTheBodyReachesIt) {
  MachineSpec machine = GoodMachine();
  machine.mutable_lenses(0)->set_free_distance_mm(40);
  machine.mutable_lenses(0)->set_mount_diameter_mm(20);
  Fixture& clamp = *machine.add_fixtures();
  clamp.set_name("left clamp");
  clamp.mutable_min_mm()->set_x(-12);
  clamp.mutable_max_mm()->set_x(-2), clamp.mutable_max_mm()->set_y(50);
  clamp.mutable_max_mm()->set_z(70);
  const FrozenJob job = JobOf(60, 43, machine);
  // 50 mm deep: the focus in air is at 27.1 mm, the edge at 67.1 mm, below the clamp.
  EXPECT_EQ(RefusalOf(job, {Vec3(9, 25, 10)}), "");
  EXPECT_THAT(RefusalOf(job, {Vec3(7, 25, 10)}),
              AllOf(HasSubstr("the lens f43 would be 2.9 mm inside the fixture \"left "
                              "clamp\""),
                    HasSubstr("away from it")));
  EXPECT_EQ(RefusalOf(job, {Vec3(7, 25, 30)}), "");
  // Around the end of the clamp: both places are free, the way is not.
  const PointList around = {Vec3(7, 70, 10), Vec3(7, -20, 10)};
  EXPECT_EQ(RefusalOf(job, around, PointOrder::kNone), "");
  EXPECT_THAT(RefusalOf(job, around), HasSubstr("on the way to point (7, -20, 10)"));
}

TEST(HeadClearance, TheHeadIsPlacedByTheWorkingDistance) {
  MachineSpec machine = GoodMachine();
  machine.mutable_head_body()->set_diameter_mm(300);
  machine.mutable_head_body()->set_above_reference_mm(-50);
  const FrozenJob job = JobOf(60, 43, machine);  // at 30 mm above the focus
  EXPECT_EQ(RefusalOf(job, {Vec3(25, 25, 60 - 45)}), "");
  EXPECT_THAT(RefusalOf(job, {Vec3(25, 25, 60 - 50)}),
              AllOf(HasSubstr("the head of els-03 would be 2.9 mm inside the block"),
                    HasSubstr("head_body and working_distance_mm")));
  machine.mutable_lenses(0)->clear_working_distance_mm();
  EXPECT_EQ(RefusalOf(JobOf(60, 43, machine), {Vec3(25, 25, 10)}), "") << "unknown";
}

TEST(HeadClearance, FixturesAreSeenFromTheBlockOfTheStation) {
  MachineSpec machine = GoodMachine();
  machine.mutable_lenses(0)->set_mount_diameter_mm(4);
  machine.mutable_loading()->set_station_count(2);
  machine.mutable_loading()->mutable_pitch_mm()->set_x(60);
  Fixture& clamp = *machine.add_fixtures();
  clamp.set_name("between");
  clamp.mutable_min_mm()->set_x(52);
  clamp.mutable_max_mm()->set_x(58), clamp.mutable_max_mm()->set_y(50);
  clamp.mutable_max_mm()->set_z(99);
  JobSpec job = JobOf(60).job();
  job.set_station(2);
  machine = WithMachineDefaults(machine);
  const HeadClearance head = HeadClearanceOf(job, machine);
  ASSERT_EQ(head.solids.size(), 2u);
  // Left of the second block: -8 to -2 mm.
  const auto meets = head.clearance.At(Vec3(-5, 25, 60 - 43));
  ASSERT_TRUE(meets);
  EXPECT_EQ(meets->solid, 1u);
  EXPECT_NEAR(meets->overlap_mm, 39, 1e-9);
  EXPECT_FALSE(head.clearance.At(Vec3(1, 25, 60 - 43)));
}

TEST(HeadCheck, ProfilesThatAreNotPossibleAreNamed) {
  EXPECT_THAT(CheckMachine(GoodMachine()), IsEmpty());
  MachineSpec machine = GoodMachine();
  machine.mutable_z()->set_travel_min_mm(-50);
  EXPECT_THAT(CheckMachine(machine), IsEmpty()) << "jobs stay in the block";
  const auto low = LensWarningsOf(machine);
  ASSERT_EQ(low.size(), 1u);
  EXPECT_THAT(low[0].message, AllOf(HasSubstr("z.travel"), HasSubstr("the lens f43"),
                                    HasSubstr("7.0 mm into the table")));
  machine = GoodMachine();
  Fixture& fixture = *machine.add_fixtures();
  fixture.mutable_max_mm()->set_x(5), fixture.mutable_max_mm()->set_y(5);
  const auto flat = CheckMachine(machine);
  ASSERT_EQ(flat.size(), 2u);
  EXPECT_THAT(flat[0].message, HasSubstr("fixtures[0].name"));
  EXPECT_THAT(flat[1].message, HasSubstr("fixtures[0].min_mm.z: 0 is not below"));
  machine = GoodMachine();
  machine.mutable_head_body()->set_diameter_mm(100);
  machine.mutable_lenses(1)->set_free_distance_mm(81);
  const auto above = CheckMachine(machine);
  ASSERT_EQ(above.size(), 1u);
  EXPECT_THAT(above[0].message, HasSubstr("lenses[1].free_distance_mm: 81 is above"));
}

// The second lens has its focus nobody knows where.
TEST(HeadCheck, LensesWithoutWorkingDistancesNeedATaughtZero) {
  MachineSpec machine = GoodMachine();
  EXPECT_THAT(LensWarningsOf(machine), IsEmpty());
  machine.mutable_lenses(1)->clear_working_distance_mm();
  const auto warnings = LensWarningsOf(machine);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0].message,
              AllOf(HasSubstr("lenses[1].working_distance_mm"),
                    HasSubstr("teach its zero (intaglio teach zero --lens f70"),
                    HasSubstr("working_distance_mm of both lenses")));
  JobSpec job = GoodJob();
  EXPECT_THAT(CheckJobOnMachine(job, machine, 0.66), IsEmpty());
  job.mutable_lens()->set_focal_length_mm(70);
  EXPECT_THAT(CheckJobOnMachine(job, machine, 0.66),
              ElementsAre(IsFinding("lens.focal_length_mm", "teach its zero")));
  TaughtZero& zero = *machine.mutable_taught()->add_zeros();
  zero.set_channel(1);
  zero.set_lens("f70");
  zero.mutable_block_origin_mm()->set_z(1);
  EXPECT_THAT(CheckJobOnMachine(job, machine, 0.66), IsEmpty());
}

TEST(HeadCheck, AModelThatIsHigherThanTheLensReachesIsRefusedAtSubmission) {
  JobSpec job = GoodJob();
  job.mutable_block()->mutable_size_mm()->set_z(100);
  const double margin_mm = WithDefaults(job, GoodMachine()).block().margin_mm();
  Placement& placement = *job.mutable_models(0)->mutable_placement();
  const double reach_mm = 43 / 0.66;
  placement.set_fit_height_mm(reach_mm - margin_mm - 0.1);
  EXPECT_THAT(CheckJobOnMachine(job, GoodMachine(), 0.66), IsEmpty());
  placement.set_fit_height_mm(reach_mm - margin_mm + 0.1);
  EXPECT_THAT(CheckJobOnMachine(job, GoodMachine(), 0.66),
              ElementsAre(IsFinding("models[0].placement.fit_height_mm",
                                    "is more than the lens f43 reaches: 65.2 mm")));
  EXPECT_THAT(CheckJobOnMachine(job, GoodMachine(), std::nullopt), IsEmpty());
}

}  // namespace
}  // namespace intaglio
