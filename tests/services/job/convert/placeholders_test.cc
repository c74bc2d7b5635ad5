#include "services/job/convert/placeholders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/convert/job_defaults.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::optional<std::string> ValueOf(const std::string& name) {
  if (name == "name") return "Anna";
  return std::nullopt;
}

TEST(Placeholders, AreFilledInWhereTheirValueIsKnown) {
  EXPECT_EQ(FillPlaceholders("Cup of {name}, {year}", ValueOf), "Cup of Anna, {year}");
  EXPECT_EQ(FillPlaceholders("{name}{name}", ValueOf), "AnnaAnna");
  EXPECT_EQ(FillPlaceholders("no { name", ValueOf), "no { name");
  EXPECT_EQ(FillPlaceholders("{}", ValueOf), "{}");
}

TEST(Placeholders, DoubledBracesAreBraces) {
  EXPECT_EQ(FillPlaceholders("{{name}} {name}", ValueOf), "{{name}} Anna");
  EXPECT_THAT(PlaceholdersOf("{{name}} {year} {{{n}}}"), ElementsAre("year", "n"));
  EXPECT_EQ(NumberedText("{{name}} {n}", 3), "{name} 3");
  EXPECT_EQ(NumberedText("{{{n}}}", 3), "{3}");
  EXPECT_EQ(NumberedText(WithDoubledBraces("{a} {n} }"), 3), "{a} {n} }");
}

TEST(Placeholders, TheNameOfATextHasNone) {
  JobSpec job = GoodJob();
  job.clear_name();
  *job.mutable_models(0) = {};
  job.mutable_models(0)->mutable_text()->set_text("{{x}} {n}");
  EXPECT_EQ(WithDefaults(job, GoodMachine()).name(), "x 1");
  *job.mutable_models(0) = {};
  job.mutable_models(0)->mutable_code()->set_text("{{x}}");
  EXPECT_EQ(WithDefaults(job, GoodMachine()).name(), "x");
}

TEST(Placeholders, ThatAreLeftAreReportedWithTheirField) {
  JobSpec job = GoodJob();
  job.set_name("badge of {name}");
  job.add_models()->mutable_text()->set_text("{year}, piece {n} of {{x}}");
  Findings findings;
  CheckPlaceholders(job, findings);
  ASSERT_EQ(findings.found().size(), 2u);
  EXPECT_EQ(findings.found()[0].field, "name");
  EXPECT_EQ(findings.found()[1].field, "models[1].text.text");
  EXPECT_THAT(findings.found()[1].message,
              AllOf(HasSubstr("{year} is not filled in"), HasSubstr("column 'year'"),
                    HasSubstr("--series"), HasSubstr("{{ and }}")));
  Findings none;
  CheckPlaceholders(GoodJob(), none);
  EXPECT_THAT(none.found(), IsEmpty());
}

}  // namespace
}  // namespace intaglio
