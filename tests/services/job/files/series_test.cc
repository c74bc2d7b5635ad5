#include "services/job/files/series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/checks/job_check.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;

JobSpec Pattern() {
  JobSpec job = GoodJob();
  job.set_name("Cup of {name}");
  Text& text = *job.add_models()->mutable_text();
  text.set_text("{name}\n{year}, piece {n}");
  text.set_font("sans.ttf");
  job.mutable_models(0)->set_file("/models/{club}.stl");
  return job;
}

const io::CsvTable kTable =
    io::ParseCsv("name,year,club\nAnna,2026,owls\n\"Smith, J.\",1999,kites\n").value();

TEST(Series, EveryRowIsAJob) {
  const auto jobs = MakeSeries(Pattern(), kTable, "/tables");
  ASSERT_TRUE(jobs.has_value()) << jobs.error().message;
  ASSERT_EQ(jobs->size(), 2u);
  EXPECT_EQ((*jobs)[0].name(), "Cup of Anna");
  EXPECT_EQ((*jobs)[1].name(), "Cup of Smith, J.");
  EXPECT_EQ((*jobs)[1].models(1).text().text(), "Smith, J.\n1999, piece {n}");
  EXPECT_EQ((*jobs)[0].models(0).file(), "/models/owls.stl");
  EXPECT_EQ((*jobs)[0].glass(), Pattern().glass());
}

TEST(Series, BracesOfAValueAreEngravedAsTheyAre) {
  const auto table = io::ParseCsv("name,year,club\n{x},{n},owls\n").value();
  const auto jobs = MakeSeries(Pattern(), table, "/tables");
  ASSERT_TRUE(jobs.has_value()) << jobs.error().message;
  EXPECT_EQ((*jobs)[0].models(1).text().text(), "{{x}}\n{{n}}, piece {n}");
  EXPECT_EQ((*jobs)[0].name(), "Cup of x");
  for (const Finding& found : CheckJob((*jobs)[0]))
    EXPECT_NE(found.field, "name") << found.message;
}

TEST(Series, NamesThatWouldBeAlikeAreNumbered) {
  JobSpec job = Pattern();
  job.set_name("Cups");
  EXPECT_EQ(MakeSeries(job, kTable, "/tables").value()[1].name(), "Cups 2");
}

TEST(Series, WhatDoesNotFitIsNamed) {
  JobSpec job = Pattern();
  job.mutable_models(1)->mutable_text()->set_text("{nmae}");
  const auto unknown = MakeSeries(job, kTable, "/tables");
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(unknown.error().message, HasSubstr("models[1].text.text"));
  EXPECT_THAT(unknown.error().message,
              HasSubstr("'nmae', did you mean name?; it has: name, year, club"));
  EXPECT_THAT(unknown.error().message, testing::Not(HasSubstr("line 3")))
      << "what is wrong with the job file is told once";
  const auto alike = MakeSeries(GoodJob(), kTable, "/tables");
  ASSERT_FALSE(alike.has_value());
  EXPECT_EQ(alike.error().code, ErrorCode::kMissing);
  EXPECT_THAT(alike.error().message, HasSubstr("column 'year'"));
  EXPECT_THAT(alike.error().message, HasSubstr("{year}"));
  EXPECT_EQ(MakeSeries(Pattern(), io::ParseCsv("name\n").value(), "/").error().code,
            ErrorCode::kMissing);
}

TEST(Series, ColumnsMayBeFieldsOfTheJob) {
  const auto table = io::ParseCsv(
                         "#note;block.margin_mm;models[0].file;glass;name;models[0]."
                         "placement.fit_height_mm\n"
                         "first;4;other.stl;K8;Anna;\n"
                         ";;;;Ben;12.5\n")
                         .value();
  const auto jobs = MakeSeries(GoodJob(), table, "/tables");
  ASSERT_TRUE(jobs.has_value()) << jobs.error().message;
  EXPECT_EQ((*jobs)[0].block().margin_mm(), 4);
  EXPECT_EQ((*jobs)[0].models(0).file(), "/tables/other.stl") << "as the table says it";
  EXPECT_EQ((*jobs)[0].glass(), "K8");
  EXPECT_EQ((*jobs)[0].name(), "Anna");
  EXPECT_EQ((*jobs)[1].glass(), GoodJob().glass()) << "an empty field changes nothing";
  EXPECT_EQ((*jobs)[1].models(0).file(), GoodJob().models(0).file());
  EXPECT_EQ((*jobs)[1].models(0).placement().fit_height_mm(), 12.5);
}

TEST(Series, EveryMistakeOfEveryRowIsReported) {
  const auto table =
      io::ParseCsv("block.margin_mm,blok.clip,laser.rate_hz\nfive,,100\n4,,fast\n")
          .value();
  const auto jobs = MakeSeries(GoodJob(), table, "/tables");
  ASSERT_FALSE(jobs.has_value());
  const std::string& message = jobs.error().message;
  EXPECT_THAT(message, HasSubstr("line 2: block.margin_mm: 'five' is not a number"));
  EXPECT_THAT(message, HasSubstr("line 2: column 'blok.clip'"));
  EXPECT_THAT(message, HasSubstr("line 3: laser.rate_hz: 'fast' is not a number"));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 2) << message;
}

TEST(Series, TwoColumnsThatExcludeEachOtherAreAMistake) {
  const auto table =
      io::ParseCsv(
          "models[0].placement.fit_height_mm,models[0].placement.fit_size_mm\n1,2\n")
          .value();
  const auto jobs = MakeSeries(GoodJob(), table, "/tables");
  ASSERT_FALSE(jobs.has_value());
  EXPECT_THAT(jobs.error().message, HasSubstr("excludes another column"));
}

// A brace that nothing closes is text.
TEST(Series, ABraceAloneStays) {
  JobSpec job = Pattern();
  job.mutable_models(1)->mutable_text()->set_text("{name} {year} {");
  EXPECT_EQ(MakeSeries(job, kTable, "/tables").value()[0].models(1).text().text(),
            "Anna 2026 {");
}

}  // namespace
}  // namespace intaglio
