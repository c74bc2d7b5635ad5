#include "engrave/core/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace intaglio {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

FileFinding Met(std::string what, Effect effect, std::string where = "") {
  return {.what = std::move(what),
          .where = std::move(where),
          .remedy = "",
          .count = 1,
          .effect = effect};
}

TEST(Findings, TheEffectAloneDecidesWhatFollows) {
  FileFindings findings;
  findings.Add(Met("VS", Effect::kNothingSeen));
  findings.Add(Met("TEXT", Effect::kLost));
  findings.Add(Met("mask", Effect::kChanged));
  const Warnings warnings = WarningsOf("plate.svg", findings);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].weight, WarningWeight::kNote);
  EXPECT_EQ(warnings[1].weight, WarningWeight::kWarning);
  EXPECT_EQ(warnings[2].weight, WarningWeight::kWarning);
  for (const Warning& warning : warnings) {
    EXPECT_EQ(warning.code, WarningCode::kLeftOut);
    EXPECT_THAT(warning.text, HasSubstr("plate.svg"));
  }
  EXPECT_TRUE(CheckMeaning("plate.svg", findings));

  findings.Add(Met("KHR_draco_mesh_compression", Effect::kMeaningLost, "extensions"));
  const Status refused = CheckMeaning("a.glb", findings);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("a.glb"));
  EXPECT_THAT(refused.error().message, HasSubstr("KHR_draco_mesh_compression"));
}

TEST(Findings, CountsThoseOfOneNameAndKeepsTheFirstPlace) {
  FileFindings findings;
  FileFinding clip = Met("clip-path", Effect::kChanged, "line 3");
  clip.area_mm2 = 2.5;
  findings.Add(clip);
  clip.where = "line 9";
  findings.Add(clip);
  EXPECT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.CountOf("clip-path"), 2U);
  EXPECT_EQ(findings.CountOf("mask"), 0U);
  const std::string text = WarningsOf("a.svg", findings).front().text;
  EXPECT_THAT(text, HasSubstr("2 x clip-path (the first: line 3) over 5 mm^2"));
  EXPECT_THAT(text, Not(HasSubstr("line 9")));
}

TEST(Findings, AFileCannotFillTheMemory) {
  FileFindings findings;
  for (int i = 0; i < 1000; ++i) {
    findings.Add(Met("a" + std::to_string(i), Effect::kLost));
  }
  findings.Add(Met(std::string(100000, '\x01'), Effect::kNothingSeen));
  EXPECT_LE(findings.size(), 66U);
  EXPECT_EQ(findings.CountOf("other"), 1000U - 64 + 1);
  FileFindings cut;
  cut.Add(Met(std::string(59, 'x') + "\xC3\xA4", Effect::kLost));
  EXPECT_EQ(cut.begin()->what, std::string(59, 'x') + "...");
  cut.Add(Met("Fr\xC3\xA4sen", Effect::kLost));
  EXPECT_EQ(cut.CountOf("Fr\xC3\xA4sen"), 1U);
}

}  // namespace
}  // namespace intaglio
