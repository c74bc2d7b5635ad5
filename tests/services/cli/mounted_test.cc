#include "services/cli/teach/mounted.h"

#include <gmock/gmock.h>

#include "services/cli/teach/mount_command.h"
#include "services/job/files/job_file.h"

namespace intaglio::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

MachineSpec Engraver() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
}

Result<MountedParts> MountedIn(bool is_virtual, const MountFlags& flags) {
  return MountedOf(flags, is_virtual, Engraver(), ":memory:");
}

TEST(Mounted, OfAVirtualMachineEverythingIsKnown) {
  const auto mounted = MountedIn(true, {});
  ASSERT_TRUE(mounted);
  EXPECT_EQ(*mounted->block_mm, Vec3(50, 50, 30));
  EXPECT_NEAR(*mounted->refractive_index, 1.51947, 1e-5);
  EXPECT_EQ(mounted->lens->focal_length_mm, 43);
  EXPECT_THAT(MountedText(*mounted, Engraver()),
              AllOf(HasSubstr("50 x 50 x 30 mm"), HasSubstr("N-BK7 of index 1.51947"),
                    HasSubstr("lens f43: f 43 mm, NA 0.0581")));
}

TEST(Mounted, OfARealMachineOnlyWhatWasGiven) {
  const auto nothing = MountedIn(false, {});
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->block_mm);
  EXPECT_FALSE(nothing->refractive_index);
  EXPECT_FALSE(nothing->lens);
  EXPECT_THAT(MountedText(*nothing, Engraver()),
              HasSubstr("its lens is not known (--lens)"));
  MachineSpec with_one = Engraver();
  while (with_one.lenses_size() > 1) with_one.mutable_lenses()->RemoveLast();
  EXPECT_THAT(MountedText(*nothing, with_one),
              HasSubstr("; lens " + with_one.lenses(0).name()));
  const auto lens = MountedIn(false, {{}, "", 0, "f70", ""});
  ASSERT_TRUE(lens);
  EXPECT_EQ(lens->lens->numerical_aperture, 5.0 / 140);
  EXPECT_FALSE(lens->refractive_index);
}

TEST(Mounted, AGlassIsGivenByItsNameOrItsIndex) {
  EXPECT_NEAR(*MountedIn(true, {{}, "fused-silica", 0, "", ""})->refractive_index, 1.4607,
              1e-3);
  const auto mounted = MountedIn(true, {{}, "", 1.7, "", ""});
  EXPECT_EQ(*mounted->refractive_index, 1.7);
  EXPECT_THAT(MountedText(*mounted, Engraver()), HasSubstr("glass of index 1.7"));
}

TEST(Mounted, TheIndexIsTheOneAtTheWavelengthThatTheLaserIsSetTo) {
  MachineSpec machine = Engraver();
  LaserWavelength& infrared = *machine.mutable_laser()->add_further_wavelengths();
  infrared.set_wavelength_nm(1064);
  infrared.set_pulse_energy_mj(70);
  const auto mounted = [&](const std::string& glass, double wavelength_nm) {
    MountFlags flags;
    flags.glass = glass;
    flags.wavelength_nm = wavelength_nm;
    return NamedParts(flags, machine, ":memory:");
  };
  EXPECT_NEAR(*mounted("N-BK7", 0)->refractive_index, 1.51947, 1e-5);
  EXPECT_NEAR(*mounted("N-BK7", 1064)->refractive_index, 1.50663, 1e-5);
  EXPECT_THAT(mounted("N-BK7", 600).error().message,
              HasSubstr("--wavelength: 600 is none of the wavelengths of els-03: 532 "
                        "1064"));
  EXPECT_THAT(mounted("", 1064).error().message, HasSubstr("name the glass, too"));
}

TEST(Mounted, WhatThereIsNotIsRefusedWithWhatThereIs) {
  const auto lens = MountedIn(true, {{}, "", 0, "f50", ""});
  ASSERT_FALSE(lens);
  EXPECT_THAT(lens.error().message, AllOf(HasSubstr("--lens"), HasSubstr("f43, f70")));
  const auto glass = MountedIn(true, {{}, "N-BK77", 0, "", ""});
  ASSERT_FALSE(glass);
  EXPECT_THAT(glass.error().message, HasSubstr("N-BK7"));
}

TEST(Mounted, OfAMachineThatMarksThePieceByItsDescription) {
  const auto galvo =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo.textproto").value();
  EXPECT_EQ(MountedOf({}, true, galvo, ":memory:")->piece, "virtual piece");
  EXPECT_TRUE(MountedOf({}, false, galvo, ":memory:")->empty());
  EXPECT_EQ(MountedOf({{}, "", 0, "", "brass"}, false, galvo, ":memory:")->piece,
            "brass");
  EXPECT_EQ(MountedText({}, galvo), "piece in the machine: it is not known (--piece)");
}

// It has no lens, whose aperture the index of a glass would be computed with.
TEST(Mounted, AMachineThatMarksIsGivenNoGlassInPlaceOfItsPiece) {
  const auto galvo =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo.textproto").value();
  const std::array given = {
      MountFlags{{50, 50, 30}, "", 0, "", ""}, MountFlags{{}, "N-BK7", 0, "", ""},
      MountFlags{{}, "", 1.5, "", "brass"}, MountFlags{{}, "", 0, "f43", ""}};
  for (const MountFlags& flags : given) {
    for (const auto& mounted : {MountedOf(flags, true, galvo, ":memory:"),
                                NamedParts(flags, galvo, ":memory:")}) {
      ASSERT_FALSE(mounted);
      EXPECT_THAT(mounted.error().message, HasSubstr("name the piece with --piece"));
    }
  }
}

// A person names what is new; the rest stays as it was reported.
TEST(Mounted, WhatIsNotNamedStays) {
  MountedParts known = MountedIn(true, {}).value();
  const MountedParts block = MergedParts(known, {.block_mm = Vec3(60, 30, 20)});
  EXPECT_EQ(TextOf(block), "60 x 30 x 20 N-BK7, f43");
  const MountedParts glass = MergedParts(known, {.refractive_index = 1.7});
  EXPECT_EQ(TextOf(glass), "50 x 50 x 30 glass of index 1.7, f43");
}

}  // namespace
}  // namespace intaglio::cli
