#include "services/job/machine/mounted_parts.h"

#include <gmock/gmock.h>

#include "engrave/optics/focus.h"
#include "tests/services/synchronizer/good_task.h"

namespace intaglio::synchronizer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const optics::Lens kF43{43, 5.0 / 86}, kF70{70, 5.0 / 140};

TEST(MountedParts, WhatIsNotKnownIsNotCompared) {
  EXPECT_EQ(MountMisfit(GoodTask(), {}), "");
}

TEST(MountedParts, TheJobsOwnBlockGlassAndLensFit) {
  const FrozenJob job = GoodTask();
  EXPECT_EQ(MountMisfit(job, {Vec3(50, 50, 30), job.optics().refractive_index(), kF43}),
            "");
}

TEST(MountedParts, AJobForAnotherLensIsNamedWithBothAndTheRemedy) {
  EXPECT_THAT(MountMisfit(GoodTask(), {.lens = kF70}),
              AllOf(HasSubstr("for the lens f43 (f 43 mm, NA 0.0581)"),
                    HasSubstr("the lens f70 (f 70 mm, NA 0.0357) is mounted"),
                    HasSubstr("no pulse is fired"),
                    HasSubstr("`intaglio mount --machine els-03 --lens f43`")));
}

TEST(MountedParts, AnotherApertureIsAnotherLens) {
  FrozenJob job = GoodTask();
  job.mutable_job()->mutable_lens()->set_numerical_aperture(0.15);
  EXPECT_THAT(MountMisfit(job, {.lens = kF43}), HasSubstr("NA 0.15"));
}

// The same index with the error of the numbers' text.
TEST(MountedParts, GlassesOfOneIndexAreOne) {
  const FrozenJob job = GoodTask();
  const double index = job.optics().refractive_index();
  EXPECT_EQ(MountMisfit(job, {.refractive_index = index + 0.0005}), "");
}

TEST(MountedParts, AJobForAnotherGlassIsNamedWithTheDepthErrorAndTheRemedy) {
  EXPECT_THAT(MountMisfit(GoodTask(), {.refractive_index = 1.46}),
              AllOf(HasSubstr("the job is for N-BK7 (refractive index 1.519"),
                    HasSubstr("has the index 1.46"), HasSubstr("0.034 mm are allowed"),
                    HasSubstr("`intaglio mount --machine els-03 --glass N-BK7`")));
}

// What matters is where the focus is: the same glasses, in a block that is low.
TEST(MountedParts, TheLimitIsAQuarterOfACrackAtTheBottomOfTheBlock) {
  FrozenJob job = GoodTask();
  const double wanted = job.optics().refractive_index(), found = wanted + 0.004;
  const double height_mm = 0.25 * 0.135 * wanted / 0.004;  // about H (m - n) / n
  job.mutable_job()->mutable_block()->mutable_size_mm()->set_z(0.95 * height_mm);
  EXPECT_EQ(MountMisfit(job, {.refractive_index = found}), "");
  job.mutable_job()->mutable_block()->mutable_size_mm()->set_z(1.05 * height_mm);
  EXPECT_NE(MountMisfit(job, {.refractive_index = found}), "");
}

// Against the focus itself: where the stage goes, and where the focus is then.
TEST(MountedParts, TheDepthErrorIsThatOfTheDeepestFocus) {
  const FrozenJob job = GoodTask("soda-lime");
  const double height_mm = job.job().block().size_mm().z();
  const double aperture = 2.5 / 43;
  const double stage_mm =
      height_mm * optics::StagePerGlassRatio(job.optics().refractive_index(), aperture);
  for (const double mounted : {1.3, 1.46, 1.52, 1.9}) {
    const double focus_mm = stage_mm / optics::StagePerGlassRatio(mounted, aperture);
    EXPECT_NEAR(DepthErrorMm(job, mounted), std::abs(focus_mm - height_mm), 1e-9);
  }
}

TEST(MountedParts, EverythingThatDiffersIsNamed) {
  EXPECT_THAT(
      MountMisfit(GoodTask(),
                  {.block_mm = Vec3(20, 20, 20), .refractive_index = 1.9, .lens = kF70}),
      AllOf(HasSubstr("20 x 20 x 20 mm"), HasSubstr("1.9"), HasSubstr("f70")));
}

TEST(MountedParts, TheJobsOwnAreNamedAndFit) {
  const FrozenJob job = GoodTask();
  const MountedParts parts = PartsOf(job);
  EXPECT_EQ(MountMisfit(job, parts), "");
  EXPECT_EQ(TextOf(parts), "50 x 50 x 30 N-BK7, f43");
  EXPECT_THAT(MountCommandFor(job),
              HasSubstr("--block 50 50 30 --glass N-BK7 --lens f43"));
}

TEST(MountedParts, WhatNobodyNamedIsMissing) {
  const FrozenJob job = GoodTask();
  EXPECT_THAT(MissingParts(job, {}), testing::ElementsAre("block", "glass", "lens"));
  EXPECT_THAT(MissingParts(job, PartsOf(job)), testing::IsEmpty());
  FrozenJob one_lens = job;
  one_lens.mutable_machine()->mutable_lenses()->DeleteSubrange(1, 1);
  EXPECT_THAT(MissingParts(one_lens, {}), testing::ElementsAre("block", "glass"));
}

TEST(MountedParts, OnlyVirtualControllersAreNoRealMachine) {
  MachineSpec machine = GoodMachine();
  machine.mutable_motion_line()->set_protocol("virtual-stage");
  EXPECT_FALSE(IsRealMachine(machine));
  machine.mutable_motion_line()->set_protocol("grbl");
  EXPECT_TRUE(IsRealMachine(machine));
}

TEST(MountedLens, IsNamedOrGivenByItsNumbers) {
  const MachineSpec machine = GoodMachine();
  EXPECT_EQ(MountedLens("f70", machine)->value().focal_length_mm, 70);
  EXPECT_EQ(MountedLens("f70", machine)->value().numerical_aperture, 5.0 / 140);
  EXPECT_EQ(MountedLens("43,0.15", machine)->value().numerical_aperture, 0.15);
}

TEST(MountedLens, IsKnownWithoutAReportWhereThereIsJustOne) {
  MachineSpec machine = GoodMachine();
  EXPECT_EQ(MountedLens("", machine).value(), std::nullopt);
  machine.mutable_lenses()->DeleteSubrange(0, 1);
  EXPECT_EQ(MountedLens("", machine)->value().focal_length_mm, 70);
}

TEST(MountedLens, AnUnknownOneIsRefusedWithThoseThereAre) {
  for (const char* wrong :
       {"f50", "50,0.2", "43", "43,", "43,0", "43,1.5", "43,x", ",0.2"}) {
    const auto lens = MountedLens(wrong, GoodMachine());
    ASSERT_FALSE(lens) << wrong;
    EXPECT_THAT(lens.error().message, AllOf(HasSubstr(wrong), HasSubstr("f43, f70")));
  }
}

}  // namespace
}  // namespace intaglio::synchronizer
