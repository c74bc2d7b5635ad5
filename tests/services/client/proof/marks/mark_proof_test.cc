// The verdict over folders made by hand: each thing that can be wrong with a piece is put
// into the material or the journal, alone, and has to be found and named.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "engrave/render/png_file.h"
#include "services/client/proof/marks/mark_figures.h"
#include "services/client/proof/marks/mark_pictures.h"
#include "services/client/proof/proof_folder.h"
#include "tests/services/client/proof/marks/mark_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::PointOutcome;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MarkFolder;

JobReport Verified(const MarkFolder& made) {
  made.Write();
  const auto proved = VerifyFolder(made.folder());
  EXPECT_TRUE(proved) << proved.error().message;
  return proved ? proved->report : JobReport();
}

/// The one reason why the verdict is not good.
std::string Reason(const MarkFolder& made) {
  const JobReport report = Verified(made);
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(report.verdict().reasons_size(), 1) << report.verdict().ShortDebugString();
  return report.verdict().reasons_size() > 0 ? report.verdict().reasons(0) : "";
}

TEST(MarkProof, APieceAsPlannedIsGood) {
  const JobReport report = Verified(MarkFolder(false));
  EXPECT_THAT(report.verdict().reasons(), IsEmpty());
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.evidence(), "material");
  const MarkReport& marks = report.marks();
  EXPECT_EQ(marks.counts().planned(), 4u);
  EXPECT_EQ(marks.counts().made(), 4u);
  EXPECT_EQ(marks.measures().gap().count(), 4u);
  EXPECT_LT(marks.measures().place().max_um(), 0.1);
  // 2 pi times the radius of each, to the chords.
  EXPECT_NEAR(marks.length_mm(), 4 * 3.14159, 1e-3);
  ASSERT_EQ(marks.energies_size(), 2);
  EXPECT_EQ(marks.energies(0).mark_count(), 3u);
  EXPECT_NEAR(marks.energies(1).median_mj_mm(), testing::kEnergyMjMm, 1e-3);
  // Four circles of 628 ticks, and 10 ms between them.
  EXPECT_NEAR(report.machining_time_s(), 4 * 628e-5 + 3 * 0.01, 1e-4);
  EXPECT_FALSE(report.has_points());
}

TEST(MarkProof, AMarkThatIsNotInTheMaterialIsMissed) {
  MarkFolder made(false);
  made.burnt_[2].clear();
  EXPECT_THAT(Reason(made), AllOf(HasSubstr("1 mark is missing in the material"),
                                  HasSubstr("mark 3 (item 1) at (6.00, 2.00) mm")));
  EXPECT_EQ(Verified(made).marks().counts().missed(), 1u);
}

TEST(MarkProof, AMarkMadeTwiceIsDoubled) {
  MarkFolder made(false);
  made.burnt_[1].push_back(made.burnt_[1][0]);
  EXPECT_THAT(Reason(made), AllOf(HasSubstr("made twice"), HasSubstr("mark 2 (item 1)")));
}

TEST(MarkProof, HalfAMarkIsIncomplete) {
  MarkFolder made(false);
  made.burnt_[3][0].turns = 0.5;
  EXPECT_THAT(Reason(made),
              AllOf(HasSubstr("made in part only"), HasSubstr("mark 4 (item 2)")));
  EXPECT_NEAR(Verified(made).marks().findings(0).burnt_ratio(), 0.5, 0.01);
}

TEST(MarkProof, AMarkThatWasSkippedIsNamed) {
  MarkFolder made(false);
  made.burnt_[0].clear();
  made.journal_[0] = PointOutcome::kSkipped;
  EXPECT_THAT(Reason(made), AllOf(HasSubstr("skipped, by the journal"),
                                  HasSubstr("mark 1 (item 1) at (0.00, 2.00) mm")));
}

TEST(MarkProof, WhatTheMaterialHasOfAnUncertainMarkIsReported) {
  MarkFolder made(false);
  made.journal_[1] = PointOutcome::kUncertain;
  EXPECT_THAT(Reason(made),
              AllOf(HasSubstr("1 mark is uncertain by the journal"),
                    HasSubstr("1 whole, 0 in part"), HasSubstr("mark 2 (item 1)")));
  const JobReport report = Verified(made);
  EXPECT_EQ(report.marks().counts().uncertain_made(), 1u);
  EXPECT_EQ(report.marks().findings(0).outcome(), "made");
  EXPECT_TRUE(report.marks().findings(0).uncertain());
}

// It is no second fault that a mark of which nobody knows is not there.
TEST(MarkProof, AnUncertainMarkThatIsNotThereHasOneReason) {
  MarkFolder made(false);
  made.journal_[1] = PointOutcome::kUncertain;
  made.burnt_[1].clear();
  EXPECT_THAT(Reason(made), HasSubstr("0 whole, 0 in part, 1 not at all"));
  EXPECT_EQ(Verified(made).marks().counts().missed(), 1u);
}

TEST(MarkProof, AMarkThatWasNotBegunAndIsThereIsUnaccounted) {
  MarkFolder made(false);
  made.journal_[2] = PointOutcome::kNone;
  EXPECT_THAT(Reason(made), AllOf(HasSubstr("the journal has them as not begun"),
                                  HasSubstr("mark 3 (item 1)")));
}

TEST(MarkProof, TicksOutsideTheMarksAreStray) {
  MarkFolder made(false);
  made.stray_ticks_ = 5;
  EXPECT_THAT(Reason(made), HasSubstr("5 ticks of 10 us outside the job's marks"));
}

TEST(MarkProof, EachMeasureBeyondTheToleranceIsNamedAlone) {
  MarkFolder place(false);
  place.burnt_[3][0].off_mm = {0.018, 0.0135};
  EXPECT_THAT(Reason(place),
              AllOf(HasSubstr("place of 1 mark beyond the tolerance of 20 um"),
                    HasSubstr("22.5 um at mark 4 (item 2) at (9.00, 2.00) mm")));
  MarkFolder within(false);
  within.burnt_[3][0].off_mm = {0.014, 0.014};
  EXPECT_TRUE(Verified(within).verdict().good());

  MarkFolder gap(false);
  // 3.14 mm less 30 um.
  gap.burnt_[1][0].turns = 1 - 0.030 / (2 * std::numbers::pi * testing::kRadiusMm);
  EXPECT_THAT(Reason(gap),
              AllOf(HasSubstr("gap of 1 mark"), HasSubstr("30.0 um at mark 2")));

  // The radius is 12 um too large: the diameter 24, the shape 12.
  MarkFolder diameter(false);
  diameter.burnt_[0][0].radius_mm += 0.012;
  EXPECT_THAT(Reason(diameter),
              AllOf(HasSubstr("diameter of 1 mark"), HasSubstr("24.0 um at mark 1")));
}

TEST(MarkProof, TheEnergyPerLengthIsThatOfEachItem) {
  MarkFolder made(false);
  for (std::size_t i = 0; i < 3; ++i)
    made.burnt_[i][0].energy_mj_mm = 2 + 0.1 * static_cast<double>(i);
  const JobReport report = Verified(made);
  const MarkEnergy& energy = report.marks().energies(0);
  EXPECT_NEAR(energy.median_mj_mm(), 2.1, 1e-4);
  // 2, 2.1 and 2.2: sqrt(2/3) * 0.1, of 2.1.
  EXPECT_NEAR(energy.spread_ratio(), std::sqrt(2.0 / 3) * 0.1 / 2.1, 1e-4);
  EXPECT_NEAR(energy.furthest_ratio(), 0.1 / 2.1, 1e-4);
  EXPECT_EQ(report.marks().energies(1).furthest_ratio(), 0);
}

TEST(MarkProof, OnAWebTheRepeatIsNamedAndAnErrorOfAllIsNone) {
  MarkFolder made(true);
  // Where the web was at the beginning is not known.
  for (auto& circles : made.burnt_) circles[0].off_mm = {1.5, 0};
  JobReport report = Verified(made);
  EXPECT_THAT(report.verdict().reasons(), IsEmpty());
  EXPECT_LT(report.marks().measures().place().max_um(), 0.1);
  EXPECT_NEAR(report.marks().web().length_mm(), 91, 0.01);
  // Three pitches of the web, from the beginning of the first circle to the end of the
  // last: four of 628 ticks, and 10 ms between them.
  EXPECT_NEAR(report.marks().web().marked_mm_s(), 90 / (4 * 628e-5 + 3 * 0.01), 10);
  EXPECT_GT(report.marks().web().largest_mm_s(), 0);
  made.burnt_[2][0].off_mm.x() += 0.025;
  EXPECT_THAT(Reason(made),
              HasSubstr("25.0 um at mark 3 (item 1, repeat 3) at (1.00, 2.00) mm"));
}

// A real machine: there is no record of its material.
TEST(MarkProof, WithoutTheMaterialTheJournalAloneDecides) {
  MarkFolder made(false);
  made.journal_[1] = PointOutcome::kUncertain;
  made.journal_[3] = PointOutcome::kMissed;
  made.WriteJob();
  const auto proved = VerifyFolder(made.folder());
  ASSERT_TRUE(proved) << proved.error().message;
  const JobReport& report = proved->report;
  EXPECT_EQ(report.evidence(), "controller");
  EXPECT_EQ(report.marks().counts().made(), 2u);
  EXPECT_EQ(report.marks().counts().uncertain(), 1u);
  EXPECT_EQ(report.marks().measures().place().count(), 0u);
  EXPECT_THAT(report.verdict().reasons(),
              ElementsAre(HasSubstr("missed, as the controller reports: mark 4"),
                          AllOf(HasSubstr("check the piece"), HasSubstr("mark 2"))));
}

// A mill: contours and a hole, no record, no scan head.
TEST(MarkProof, ContoursOfAToolAreProvedByTheJournal) {
  MarkFolder made(false);
  made.frozen_.mutable_job()->clear_marks();
  made.frozen_.mutable_job()->mutable_course()->add_files("plate.dxf");
  made.frozen_.mutable_machine()->clear_scan_head();
  made.marks_.pens[0].name = "contours, 1 mm deep";
  made.marks_.marks[3].closed = false;
  made.marks_.marks[3].places = {{Vec2(4, 5), 0}};
  made.WriteJob();
  const auto good = CompleteFolder({made.folder(), "", false});
  ASSERT_TRUE(good) << good.error().message;
  EXPECT_FALSE(good->not_written) << good->not_written->message;
  EXPECT_TRUE(good->report.verdict().good());
  EXPECT_EQ(good->report.evidence(), "controller");
  EXPECT_EQ(good->report.marks().counts().made(), 4u);
  EXPECT_FALSE(good->report.marks().has_web());
  EXPECT_TRUE(fs::exists(made.folder() / "views.png"));

  made.journal_[0] = made.journal_[3] = PointOutcome::kUncertain;
  made.WriteJob();
  const auto proved = VerifyFolder(made.folder());
  ASSERT_TRUE(proved);
  EXPECT_THAT(proved->report.verdict().reasons(),
              ElementsAre(AllOf(HasSubstr("unknown whether 2 marks were made"),
                                HasSubstr("mark 1 (contours, 1 mm deep) at (0.00, 2.00)"),
                                HasSubstr("mark 4 (item 2) at (4.00, 5.00) mm"))));
}

TEST(MarkProof, TheJournalOfOtherMarksIsRefused) {
  MarkFolder made(false);
  made.WriteJob();
  made.marks_.marks.pop_back();
  ASSERT_TRUE(mark::WriteMarkFile(made.folder() / "marks.bin", made.marks_));
  const auto proved = VerifyFolder(made.folder());
  ASSERT_FALSE(proved);
  EXPECT_EQ(proved.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(proved.error().message,
              AllOf(HasSubstr("journal.bin"), HasSubstr("4 marks"), HasSubstr("has 3")));
}

TEST(MarkProof, ADamagedRecordIsNotTakenForMissingMarks) {
  MarkFolder made(false);
  made.Write();
  const fs::path file = made.folder() / "burnt.rec";
  fs::resize_file(file, fs::file_size(file) - 20);
  const auto proved = VerifyFolder(made.folder());
  ASSERT_FALSE(proved);
  EXPECT_THAT(proved.error().message, HasSubstr("burnt.rec: cut or damaged"));
}

TEST(MarkProof, CompletingAFolderWritesWhatWasBurntReportAndPicture) {
  MarkFolder made(false);
  made.WriteJob();
  const fs::path records = made.folder() / "records";
  fs::create_directory(records);
  ASSERT_TRUE(formats::WriteMarkRecord(records / "marks-0000beef.rec", made.Record()));
  const auto proved = CompleteFolder({made.folder(), records, false});
  ASSERT_TRUE(proved) << proved.error().message;
  EXPECT_FALSE(proved->not_written) << proved->not_written->message;
  EXPECT_TRUE(proved->report.verdict().good());
  EXPECT_EQ(proved->report.evidence(), "material");
  for (const char* file : {"burnt.rec", "report.json", "views.png"})
    EXPECT_TRUE(fs::exists(made.folder() / file)) << file;
}

TEST(MarkProof, ThePictureShowsTheGravestMarksAndAllErrors) {
  MarkFolder made(false);
  made.burnt_[1][0].off_mm = {0.03, 0};
  made.burnt_[2].clear();
  made.Write();
  const auto evidence = ReadMarkEvidence(made.folder());
  ASSERT_TRUE(evidence);
  const auto proved = VerifyFolder(made.folder());
  ASSERT_TRUE(proved);
  const render::MarkViews views = MarkViewsOf(*evidence, proved->report);
  EXPECT_EQ(views.caption.verdict, "NOT GOOD");
  ASSERT_EQ(views.errors.size(), 4u);
  EXPECT_NEAR(views.errors[1].error_um, 30, 0.1);
  EXPECT_EQ(views.errors[2].state, render::MarkState::kMissed);
  ASSERT_EQ(views.close_ups.size(), 3u);
  EXPECT_EQ(views.close_ups[0].title, "Mark 3");
  EXPECT_THAT(views.close_ups[0].burnt, IsEmpty());
  EXPECT_EQ(views.close_ups[1].title, "Mark 2");
  EXPECT_THAT(views.close_ups[1].lines, ::testing::Contains(HasSubstr("place 30.0")));
}

}  // namespace
}  // namespace intaglio::client
