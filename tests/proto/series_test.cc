#include "proto/series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/proto/test_job.h"

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

const formats::CsvTable kTable =
    formats::ParseCsv("name,year,club\nAnna,2026,owls\n\"Smith, J.\",1999,kites\n")
        .value();

TEST(Series, EveryRowIsAJob) {
  const auto jobs = MakeSeries(Pattern(), kTable);
  ASSERT_TRUE(jobs.has_value()) << jobs.error().message;
  ASSERT_EQ(jobs->size(), 2u);
  EXPECT_EQ((*jobs)[0].name(), "Cup of Anna");
  EXPECT_EQ((*jobs)[1].name(), "Cup of Smith, J.");
  EXPECT_EQ((*jobs)[1].models(1).text().text(), "Smith, J.\n1999, piece {n}");
  EXPECT_EQ((*jobs)[0].models(0).file(), "/models/owls.stl");
  EXPECT_EQ((*jobs)[0].glass(), Pattern().glass());
}

TEST(Series, NamesThatWouldBeAlikeAreNumbered) {
  JobSpec job = Pattern();
  job.set_name("Cups");
  EXPECT_EQ(MakeSeries(job, kTable).value()[1].name(), "Cups 2");
}

TEST(Series, WhatDoesNotFitIsNamed) {
  JobSpec job = Pattern();
  job.mutable_models(1)->mutable_text()->set_text("{nmae}");
  const auto unknown = MakeSeries(job, kTable);
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(unknown.error().message, HasSubstr("models[1].text.text"));
  EXPECT_THAT(unknown.error().message, HasSubstr("name, year, club"));
  EXPECT_EQ(MakeSeries(GoodJob(), kTable).error().code, ErrorCode::kMissing);
  EXPECT_EQ(MakeSeries(Pattern(), formats::ParseCsv("name\n").value()).error().code,
            ErrorCode::kMissing);
}

// A brace that nothing closes is text.
TEST(Series, ABraceAloneStays) {
  JobSpec job = Pattern();
  job.mutable_models(1)->mutable_text()->set_text("{name} {");
  EXPECT_EQ(MakeSeries(job, kTable).value()[0].models(1).text().text(), "Anna {");
}

}  // namespace
}  // namespace intaglio
