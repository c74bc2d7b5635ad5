#include "services/cli/mounted.h"

#include <gmock/gmock.h>

#include "services/job/job_file.h"

namespace intaglio::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Result<Mounted> MountedIn(bool is_virtual, const MountFlags& flags) {
  const auto machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  return MountedOf(flags, is_virtual, machine.value(), ":memory:");
}

TEST(Mounted, OfAVirtualMachineEverythingIsKnown) {
  const auto mounted = MountedIn(true, {});
  ASSERT_TRUE(mounted);
  EXPECT_EQ(*mounted->description.block_size_mm, Vec3(100, 100, 100));
  EXPECT_NEAR(*mounted->description.refractive_index, 1.51947, 1e-5);
  EXPECT_EQ(mounted->description.lens->focal_length_mm, 43);
  EXPECT_THAT(TextOf(*mounted),
              AllOf(HasSubstr("100 x 100 x 100 mm"), HasSubstr("N-BK7 of index 1.51947"),
                    HasSubstr("lens f43: f 43 mm, NA 0.0581")));
}

TEST(Mounted, OfARealMachineOnlyWhatWasGiven) {
  const auto nothing = MountedIn(false, {});
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->description.block_size_mm);
  EXPECT_FALSE(nothing->description.refractive_index);
  EXPECT_FALSE(nothing->description.lens);
  EXPECT_THAT(TextOf(*nothing), HasSubstr("its lens is not known (--lens)"));
  const auto lens = MountedIn(false, {{}, "", 0, "f70"});
  ASSERT_TRUE(lens);
  EXPECT_EQ(lens->description.lens->numerical_aperture, 5.0 / 140);
  EXPECT_FALSE(lens->description.refractive_index);
}

TEST(Mounted, AGlassIsGivenByItsNameOrItsIndex) {
  EXPECT_NEAR(*MountedIn(true, {{}, "fused-silica", 0, ""})->description.refractive_index,
              1.4607, 1e-3);
  const auto mounted = MountedIn(true, {{}, "", 1.7, ""});
  EXPECT_EQ(*mounted->description.refractive_index, 1.7);
  EXPECT_THAT(TextOf(*mounted), HasSubstr("glass of index 1.7"));
}

TEST(Mounted, WhatThereIsNotIsRefusedWithWhatThereIs) {
  const auto lens = MountedIn(true, {{}, "", 0, "f50"});
  ASSERT_FALSE(lens);
  EXPECT_THAT(lens.error().message, AllOf(HasSubstr("--lens"), HasSubstr("f43, f70")));
  const auto glass = MountedIn(true, {{}, "N-BK77", 0, ""});
  ASSERT_FALSE(glass);
  EXPECT_THAT(glass.error().message, HasSubstr("N-BK7"));
}

}  // namespace
}  // namespace intaglio::cli
