#include "services/client/proof/evidence/proof_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "services/client/proof/proof_verdict.h"

namespace intaglio::client {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

JobReport Report(const std::string& evidence) {
  JobReport report;
  report.set_name("bunny");
  report.set_job_uid("1-abc");
  report.set_job_number(12);
  report.set_ended_utc("2026-11-23T08:12:34.567Z");
  report.set_evidence(evidence);
  for (const double side : {60.0, 50.0, 40.0}) {
    Vector3& size = *report.mutable_job()->mutable_block()->mutable_size_mm();
    (side == 60 ? size.set_x(side) : side == 50 ? size.set_y(side) : size.set_z(side));
  }
  report.mutable_material()->set_name("N-BK7");
  report.mutable_machine()->set_name("els-03");
  report.mutable_points()->set_planned(100);
  report.mutable_points()->set_made(100);
  Judge(report);
  return report;
}

const Box3 kWork{Vec3(10, 10, 5), Vec3(50.25, 41, 35)};

std::vector<std::string> Labels(const render::ViewsCaption& caption) {
  std::vector<std::string> labels;
  for (const auto& figure : caption.figures) labels.push_back(figure.label);
  return labels;
}

TEST(ProofPictures, NameNumberDateAndSizesAreThere) {
  const auto caption = ViewsCaptionOf(Report("glass"), kWork);
  ASSERT_EQ(caption.title_lines.size(), 3u);
  EXPECT_EQ(caption.title_lines[0], "bunny");
  EXPECT_EQ(caption.title_lines[1],
            "job 12, 2026-11-23 08:12 UTC, engraving 40.25 x 31 x 30 mm, block 60 x 50 x "
            "40 mm of N-BK7");
  EXPECT_THAT(caption.title_lines[2], HasSubstr("els-03"));
}

TEST(ProofPictures, WhatNobodyMeasuredIsNotProved) {
  const auto measured = ViewsCaptionOf(Report("glass"), kWork);
  EXPECT_EQ(measured.verdict, "PROVED");
  EXPECT_THAT(measured.notes.at(0).text, HasSubstr("Measured"));
  EXPECT_THAT(Labels(measured), Contains("stray"));
  const auto counted = ViewsCaptionOf(Report("controller"), kWork);
  EXPECT_EQ(counted.verdict, "COMPLETE");
  EXPECT_THAT(counted.notes.at(0).text, HasSubstr("laser controller's counters"));
  for (const char* unknown : {"stray", "doubled", "error, max"}) {
    EXPECT_THAT(Labels(counted), Not(Contains(unknown)));
  }
  EXPECT_THAT(Labels(counted), Contains("uncertain"));
}

TEST(ProofPictures, WarningsAndReasonsAreBesideTheVerdict) {
  JobReport report = Report("glass");
  WarningRecord& note = *report.add_warnings();
  note.set_weight("note");
  note.set_text("a note");
  WarningRecord& warning = *report.add_warnings();
  warning.set_weight("warning");
  warning.set_code("odd_rays");
  warning.set_text("3 rays are odd");
  Judge(report);
  const auto warned = ViewsCaptionOf(report, kWork);
  EXPECT_EQ(warned.verdict, "GOOD, WITH WARNINGS");
  EXPECT_EQ(warned.verdict_tone, render::Tone::kWarning);
  ASSERT_EQ(warned.notes.size(), 3u);
  EXPECT_EQ(warned.notes[1].text, "3 rays are odd") << "the gravest first";
  EXPECT_EQ(warned.notes[1].tone, render::Tone::kWarning);
  EXPECT_EQ(warned.notes[2].tone, render::Tone::kPlain);

  report.mutable_points()->set_stray(2);
  Judge(report);
  const auto bad = ViewsCaptionOf(report, kWork);
  EXPECT_EQ(bad.verdict, "NOT GOOD");
  EXPECT_THAT(bad.notes.at(1).text, HasSubstr("2 cracks belong to no planned point"));
  EXPECT_EQ(bad.notes.at(1).tone, render::Tone::kBad);
}

TEST(ProofPictures, TheLegendExplainsTheTermsOfTheFigures) {
  for (const char* evidence : {"glass", "controller"}) {
    const auto caption = ViewsCaptionOf(Report(evidence), kWork);
    const auto labels = Labels(caption);
    EXPECT_GE(caption.legend.size(), 5u);
    for (const auto& entry : caption.legend) {
      EXPECT_TRUE(std::any_of(
          labels.begin(), labels.end(),
          [&](const std::string& label) { return label.starts_with(entry.term); }))
          << entry.term;
      EXPECT_FALSE(entry.meaning.empty());
    }
  }
}

TEST(ProofPictures, OfARealMachineThePicturesShowTheMadePoints) {
  Evidence evidence;
  evidence.plan_mm = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  evidence.history.resize(3);
  evidence.history[1].outcome = formats::PointOutcome::kMade;
  PointList made_mm;
  EXPECT_EQ(PicturePoints(evidence, made_mm), PointList{Vec3(2, 2, 2)});
  evidence.has_glass = true;
  evidence.cracks = {{Vec3(9, 9, 9), Vec3(8, 8, 8)}, {5, 6}, {1, 1}};
  EXPECT_EQ(PicturePoints(evidence, made_mm).size(), 2u);
}

}  // namespace
}  // namespace intaglio::client
