// Texts of jobs: fonts, letters of other fonts, and the height that fits. The block of
// the sample job is 50 x 50 x 30 mm with a margin of 3 mm: a text lies in its middle.

#include "services/job/models/text_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/font_list.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "tests/engrave/drawing/lengths.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kAleph = "\u05D0";
constexpr const char* kLong = "Maximiliane-Josephine";

struct OneText {
  JobSpec job = GoodJob();
  Model& model = (job.mutable_models(0)->Clear(), *job.mutable_models(0));
  Text& text = *model.mutable_text();

  explicit OneText(const std::string& letters, const char* family = "DejaVu Sans") {
    text.set_text(letters);
    text.set_font(drawing::FindFontFile(family).value_or(family));
  }

  JobSpec Whole() const { return WithDefaults(job, GoodMachine()); }
  Result<OutlinedText> Outline() const {
    const JobSpec whole = Whole();
    std::vector<drawing::FontSource> fonts = {{text.font()}};
    for (const std::string& font : text.fallback_fonts()) fonts.push_back({font});
    return OutlineText(whole, whole.models(0), fonts);
  }
  std::string RefusalOf() const {
    const auto outlined = Outline();
    return outlined ? "" : outlined.error().message;
  }
};

Vec3 SizeOf(const drawing::Drawing& outline) {
  return drawing::ExtentOf(*drawing::Flatten(outline)).size_mm();
}

TEST(TextModel, ATextThatFitsKeepsItsHeight) {
  OneText one("Anna");
  one.text.set_shrink_to_fit(true);
  const auto outlined = one.Outline();
  ASSERT_TRUE(outlined) << outlined.error().message;
  EXPECT_EQ(outlined->height_mm, 5);
  EXPECT_THAT(outlined->warnings, IsEmpty());
}

TEST(TextModel, ATextThatIsTooWideIsRefusedWithTheHeightThatFits) {
  OneText one(kLong);
  const std::string refusal = one.RefusalOf();
  EXPECT_THAT(refusal, AllOf(HasSubstr(kLong), HasSubstr("reaches from x = "),
                             HasSubstr("the block leaves 3 to 47 mm"),
                             HasSubstr("shrink_to_fit: true")));
  // The height that it names is taken, and hardly more.
  const auto at = refusal.find("use height_mm ");
  ASSERT_NE(at, std::string::npos);
  const double height_mm = std::stod(refusal.substr(at + 14));
  one.text.set_height_mm(height_mm);
  EXPECT_TRUE(one.Outline());
  one.text.set_height_mm(height_mm + 0.02);
  EXPECT_FALSE(one.Outline());
}

TEST(TextModel, ShrinksToFitAndReportsTheHeight) {
  OneText one(kLong);
  one.text.set_shrink_to_fit(true);
  const auto outlined = one.Outline();
  ASSERT_TRUE(outlined) << outlined.error().message;
  EXPECT_LT(outlined->height_mm, 5);
  const double width_mm = SizeOf(outlined->outlines.at(0)).x();
  EXPECT_LE(width_mm, 44);
  // A step of 0.01 mm in the height is less than 0.2 mm in the width.
  EXPECT_GT(width_mm, 43.8);
  ASSERT_EQ(outlined->warnings.size(), 1u);
  EXPECT_THAT(
      outlined->warnings[0].text,
      HasSubstr(fmt::format("{:g} mm high instead of 5 mm", outlined->height_mm)));
}

TEST(TextModel, FitsTheBoxThatTheJobGivesIt) {
  OneText one("Anna\nBerta");
  one.text.set_max_width_mm(8);
  EXPECT_THAT(one.RefusalOf(), HasSubstr("more than max_width_mm, 8"));
  one.text.set_shrink_to_fit(true);
  ASSERT_TRUE(one.Outline());
  EXPECT_LE(SizeOf(one.Outline()->outlines.at(0)).x(), 8 + 1e-6);
  one.text.set_max_height_mm(3);
  EXPECT_LE(SizeOf(one.Outline()->outlines.at(0)).y(), 3 + 1e-6);
  // Upright it is as wide and as high.
  one.model.mutable_placement()->mutable_rotate_deg()->set_x(90);
  EXPECT_LE(SizeOf(one.Outline()->outlines.at(0)).y(), 3 + 1e-6);
}

TEST(TextModel, TheCopiesAndTheirNumbersCount) {
  OneText one("Piece {n}");
  Copies& copies = *one.model.mutable_copies();
  copies.set_count_x(10);
  copies.mutable_step_mm()->set_x(4);
  EXPECT_THAT(one.RefusalOf(), HasSubstr("\"Piece 1\" reaches from x = "));
  one.text.set_shrink_to_fit(true);
  const auto outlined = one.Outline();
  ASSERT_TRUE(outlined) << outlined.error().message;
  ASSERT_EQ(outlined->outlines.size(), 10u);
  // All are of one height; the first and the last stay between the margins, 36 mm apart.
  EXPECT_LE(SizeOf(outlined->outlines.front()).x(), 44 - 36 + 1e-6);
  EXPECT_LE(SizeOf(outlined->outlines.back()).x(), 44 - 36 + 1e-6);
  EXPECT_GT(SizeOf(outlined->outlines.back()).x(),
            SizeOf(outlined->outlines.front()).x());
}

TEST(TextModel, WhereNoHeightHelpsThePlaceIsToBlame) {
  OneText one("Anna");
  one.text.set_shrink_to_fit(true);
  one.model.mutable_placement()->mutable_move_mm()->set_x(40);
  EXPECT_THAT(one.RefusalOf(), HasSubstr("a smaller height does not help"));
  one.job.mutable_block()->set_clip(true);
  EXPECT_EQ(one.RefusalOf(), "") << "clipped as the job wants it";
}

TEST(TextModel, ACharacterMayComeFromAFallbackFont) {
  OneText one(std::string("Anna ") + kAleph, "DejaVu Serif");
  EXPECT_THAT(one.RefusalOf(), AllOf(HasSubstr("U+05D0"), HasSubstr("DejaVu Serif")));
  one.text.add_fallback_fonts(*drawing::FindFontFile("DejaVu Sans"));
  const auto outlined = one.Outline();
  ASSERT_TRUE(outlined) << outlined.error().message;
  ASSERT_EQ(outlined->warnings.size(), 1u);
  EXPECT_THAT(
      outlined->warnings[0].text,
      AllOf(HasSubstr(kAleph), HasSubstr("DejaVu Sans"), HasSubstr("DejaVu Serif")));
}

TEST(ResolveFonts, NamesTheFilesThatAreNeeded) {
  OneText one(std::string("Anna ") + kAleph, "DejaVu Serif");
  EXPECT_THAT(ResolveFonts(one.job), IsEmpty());
  EXPECT_EQ(one.text.fallback_fonts_size(), 1);
  OneText plain("Anna", "DejaVu Serif");
  EXPECT_THAT(ResolveFonts(plain.job), IsEmpty());
  EXPECT_EQ(plain.text.fallback_fonts_size(), 0);
}

TEST(ResolveFonts, TakesTheListOfTheJobAndNoneForNone) {
  OneText one(std::string("Anna ") + kAleph, "DejaVu Serif");
  one.text.add_fallback_fonts("DejaVu Sans Mono");
  one.text.add_fallback_fonts("DejaVu Sans:Bold");
  EXPECT_THAT(ResolveFonts(one.job), IsEmpty());
  EXPECT_THAT(one.text.fallback_fonts(),
              ElementsAre(*drawing::FindFontFile("DejaVu Sans:Bold")));
  OneText none(std::string("Anna ") + kAleph, "DejaVu Serif");
  none.text.add_fallback_fonts(kNoFallback);
  EXPECT_THAT(ResolveFonts(none.job), IsEmpty());
  EXPECT_EQ(none.text.fallback_fonts_size(), 0);
  OneText absent("Anna");
  absent.text.add_fallback_fonts("No Such Family");
  const auto found = ResolveFonts(absent.job);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "models[0].text.fallback_fonts[0]");
}

TEST(CheckTexts, EveryTextThatCannotBeEngravedIsNamed) {
  OneText one("\U0001F984");
  *one.job.add_models() = one.job.models(0);
  one.job.mutable_models(1)->mutable_text()->set_text(kLong);
  Warnings notes;
  const auto found = CheckTexts(one.Whole(), notes);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_THAT(found[0].message,
              AllOf(HasSubstr("models[0].text.text: "), HasSubstr("U+1F984")));
  EXPECT_THAT(found[1].message,
              AllOf(HasSubstr("models[1].text.text: "), HasSubstr(kLong)));
  EXPECT_THAT(notes, IsEmpty());
}

TEST(CheckJob, AFontThatIsNotInstalledIsNamed) {
  OneText one("Anna", "DejaVoo Sans");
  const auto found = CheckJob(one.job);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "models[0].text.font");
  EXPECT_THAT(found[0].message,
              AllOf(HasSubstr("is not installed"), HasSubstr("DejaVu Sans"),
                    Not(HasSubstr("does not exist"))));
}

TEST(CheckJob, AFitAndShrinkToFitExcludeEachOther) {
  OneText one("Anna");
  one.text.set_shrink_to_fit(true);
  one.model.mutable_placement()->set_fit_size_mm(20);
  const auto found = CheckJob(one.job);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "models[0].text.shrink_to_fit");
}

}  // namespace
}  // namespace intaglio
