// Pictures as people have them: logos on transparent ground, with dark borders, turned.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/services/job/models/one_model.h"

namespace intaglio {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kPictureFiles = INTAGLIO_SOURCE_DIR "/tests/data/kinds/";

// A block that is chosen from the bright points alone is smaller than the size that was
// asked for, and the job is refused.
TEST(PictureModels, TheSizeOfAFittedOneIsThatOfItsFrame) {
  OneModel one;
  one.job.mutable_block()->mutable_size_mm()->set_z(50);
  one.model.set_file(kPictureFiles +
                     "dark_border.png");  // a bright disc of 80 of 200 pixels
  one.model.mutable_placement()->set_fit_size_mm(40);
  const auto disc = SizesOf(WithDefaults(one.job, GoodMachine()), {});
  ASSERT_TRUE(disc) << disc.error().message;
  EXPECT_NEAR(disc->front().size_mm.x(), 40, 1e-9);
  EXPECT_NEAR(disc->front().size_mm.z(), 40, 1e-9);
  one.model.set_file(kPictureFiles + "turned.png");  // 30 x 60 after its EXIF orientation
  const auto turned = SizesOf(WithDefaults(one.job, GoodMachine()), {});
  ASSERT_TRUE(turned) << turned.error().message;
  EXPECT_NEAR(turned->front().size_mm.x(), 20, 1e-9);
  EXPECT_NEAR(turned->front().size_mm.z(), 40, 1e-9);
}

TEST(PictureModels, OneEvenGreyIsWarnedOf) {
  OneModel one;
  const auto warnings_of = [&](const std::string& file) {
    one.model.set_file(kPictureFiles + file);
    one.model.mutable_placement()->set_fit_size_mm(20);
    const JobSpec whole = WithDefaults(one.job, GoodMachine());
    const auto files = ReadFilesOf(whole, {});
    EXPECT_TRUE(files);
    const auto made = MakeSources(whole, *files, {}, {});
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->warnings : Warnings();
  };
  const auto even = Contains(
      AllOf(Field(&Warning::weight, WarningWeight::kWarning),
            Field(&Warning::text, HasSubstr("white_logo.png: all its pixels have the "
                                            "same grey"))));
  EXPECT_THAT(warnings_of("white_logo.png"), even);
  EXPECT_THAT(warnings_of("dark_border.png"),
              Not(Contains(Field(&Warning::text, HasSubstr("grey")))));
}

}  // namespace
}  // namespace intaglio
