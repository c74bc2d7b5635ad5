// The verdict over folders made by hand: each thing that can be wrong with a block is
// put into the glass or the journal, alone, and has to be found and named.

#include "services/client/proof/proof_folder.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "services/client/proof/evidence/collisions.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::JournalKind;
using formats::JournalRecord;
using formats::PointOutcome;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr double kSpacingMm = 0.3;
constexpr double kToleranceUm = 20;
constexpr std::uint64_t kFirstTick = 1000;

/// Four points of two layers, fired from below, 0.4 mm apart, all as planned.
class ProofFolderTest : public ::testing::Test {
 protected:
  ProofFolderTest() : folder_(test::FreshFolder()) {
    plan_mm_ = {{10, 10, 10}, {10.4, 10, 10}, {10, 10, 10.4}, {10.4, 10, 10.4}};
    for (std::size_t i = 0; i < plan_mm_.size(); ++i) {
      cracks_mm_.push_back(plan_mm_[i]);
      ticks_.push_back(static_cast<double>(kFirstTick + 2 * i));
      outcomes_.push_back(PointOutcome::kMade);
    }
    frozen_.set_job_uid("1-abc");
    JobSpec& job = *frozen_.mutable_job();
    job.set_name("four points");
    job.mutable_discretization()->set_min_spacing_mm(kSpacingMm);
    job.mutable_laser()->set_rate_hz(100);
    job.mutable_laser()->add_channels(1);
    source_.assign(plan_mm_.size(), 0);
    channels_.assign(plan_mm_.size(), 0);
    Vector3& size = *job.mutable_block()->mutable_size_mm();
    size.set_x(20);
    size.set_y(20);
    size.set_z(20);
    frozen_.mutable_machine()->set_position_tolerance_um(kToleranceUm);
    frozen_.mutable_optics()->set_cone_tangent(0.1);
  }

  void WriteJob(const fs::path& folder) const {
    std::string json;
    ASSERT_TRUE(google::protobuf::util::MessageToJsonString(frozen_, &json).ok());
    std::ofstream(folder / "job.json") << json;
  }
  /// An intent and its outcome for every point; kNone: an intent and no more.
  void WriteJournal(const fs::path& file) const {
    std::ofstream out(file, std::ios::binary);
    const auto put = [&](const auto& bytes) {
      out.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
    };
    put(formats::EncodeJournalHeader({plan_mm_.size(), 1}));
    for (std::uint32_t i = 0; i < outcomes_.size(); ++i) {
      JournalRecord record;
      record.tick = kFirstTick + 2 * i;
      record.point = i;
      put(formats::EncodeJournalRecord(record));
      if (outcomes_[i] == PointOutcome::kNone) continue;
      record.kind = JournalKind::kOutcome;
      record.outcome = outcomes_[i];
      put(formats::EncodeJournalRecord(record));
      if (std::find(reopened_.begin(), reopened_.end(), i) == reopened_.end()) continue;
      record.kind = JournalKind::kReopened;
      put(formats::EncodeJournalRecord(record));
    }
  }
  void WriteFolder() const {
    WriteJob(folder_);
    WriteJournal(folder_ / "journal.bin");
    formats::PointTable plan, glass;
    plan.points_mm = plan_mm_;
    plan.columns = {{"source", source_}};
    ASSERT_TRUE(formats::WritePly(folder_ / "path.ply", plan));
    glass.points_mm = cracks_mm_;
    std::vector<std::uint8_t> channels = channels_;
    channels.resize(cracks_mm_.size(), 0);
    glass.columns = {{"tick", ticks_}, {"channel", channels}};
    if (!stations_.empty()) glass.columns.push_back({"station", stations_});
    ASSERT_TRUE(formats::WritePly(folder_ / "glass.ply", glass));
  }
  JobReport Verified() const {
    WriteFolder();
    const auto report = VerifyFolder(folder_);
    EXPECT_TRUE(report) << report.error().message;
    return report ? report->report : JobReport();
  }
  /// The one reason why the verdict is not good.
  std::string Reason() const {
    const JobReport report = Verified();
    EXPECT_FALSE(report.verdict().good());
    EXPECT_EQ(report.verdict().reasons_size(), 1) << report.verdict().ShortDebugString();
    return report.verdict().reasons_size() > 0 ? report.verdict().reasons(0) : "";
  }
  void Unmake(std::size_t point, PointOutcome outcome) {
    cracks_mm_.erase(cracks_mm_.begin() + static_cast<std::ptrdiff_t>(point));
    ticks_.erase(ticks_.begin() + static_cast<std::ptrdiff_t>(point));
    outcomes_[point] = outcome;
  }

  void GiveLimits() {
    MachineSpec& machine = *frozen_.mutable_machine();
    for (AxisLimits* axis :
         {machine.mutable_x(), machine.mutable_y(), machine.mutable_z()}) {
      axis->set_travel_max_mm(100);
      axis->set_max_speed_mm_s(80);
      axis->set_max_acceleration_mm_s2(7000);
    }
    frozen_.mutable_optics()->set_stage_per_glass_ratio(0.65);
  }

  fs::path folder_;
  FrozenJob frozen_;
  PointList plan_mm_, cracks_mm_;
  std::vector<std::uint32_t> source_;
  std::vector<std::uint8_t> channels_;
  std::vector<std::uint8_t> stations_;  ///< of the cracks; empty: not in the file
  std::vector<double> ticks_;
  std::vector<PointOutcome> outcomes_;
  std::vector<std::uint32_t> reopened_;  ///< after their outcomes
};

// At the right place of a block that another job is for.
TEST_F(ProofFolderTest, ACrackInTheBlockOfAnotherStationIsStrayAndMakesNoPoint) {
  frozen_.mutable_job()->set_station(2);
  stations_.assign(cracks_mm_.size(), 2);
  JobReport report = Verified();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.station(), 2u);
  EXPECT_EQ(report.points().stray(), 0u);
  stations_[1] = 3;
  report = Verified();
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(report.points().stray(), 1u);
  EXPECT_EQ(report.points().made(), report.points().planned() - 1);
}

TEST_F(ProofFolderTest, ABlockAsPlannedIsGood) {
  const JobReport report = Verified();
  EXPECT_TRUE(report.verdict().good()) << report.verdict().ShortDebugString();
  EXPECT_EQ(report.points().planned(), 4u);
  EXPECT_EQ(report.points().made(), 4u);
  EXPECT_EQ(report.position_errors().max_um(), 0);
  EXPECT_DOUBLE_EQ(report.measured_spacing_mm(), 10.4 - 10);
  // First pulse at 1000, last at 1006: seven ticks of 10 ms.
  EXPECT_EQ(report.ticks(), 7u);
  EXPECT_DOUBLE_EQ(report.machining_time_s(), 0.07);
  EXPECT_DOUBLE_EQ(report.utilisation(), 4.0 / 7);
  EXPECT_FALSE(report.has_ticks_bound()) << "of a machine without limits";
}

TEST_F(ProofFolderTest, TheBoundOfTicksIsBelowThem) {
  GiveLimits();
  const JobReport report = Verified();
  EXPECT_TRUE(report.has_ticks_bound());
  EXPECT_GE(report.ticks_bound(), 4u);
  EXPECT_LE(report.ticks_bound(), 7u);
}

// A job whose points are not all made took the time of other moves.
TEST_F(ProofFolderTest, ThereIsNoBoundOfTicksIfAPointIsMissing) {
  GiveLimits();
  Unmake(1, PointOutcome::kMissed);
  EXPECT_FALSE(Verified().has_ticks_bound());
}

// One a body and what it met, at its deepest, however often it was recorded.
TEST_F(ProofFolderTest, ACollisionIsNotGoodAndNamesWhatMetWhatAndHowDeep) {
  ASSERT_TRUE(WriteCollisions({{1001, Vec3(10, 10, 12), 0.2, 0, 0},
                               {1002, Vec3(10, 10, 5), 7.25, 0, 0},
                               {1003, Vec3(10, 10, 9), 3, 0, 0}},
                              folder_));
  EXPECT_THAT(Reason(), AllOf(HasSubstr("the lens was 7.2 mm inside the block"),
                              HasSubstr("10.0, 10.0, 5.0 mm"), HasSubstr("tick 1001")));
  EXPECT_EQ(Verified().collisions_size(), 1);
  ASSERT_TRUE(WriteCollisions({{1001, Vec3(10, 10, 12), 0.2, 1, 2}}, folder_));
  EXPECT_THAT(Reason(), HasSubstr("the head was 0.2 mm inside the fixture 2"));
  ASSERT_TRUE(WriteCollisions({}, folder_));
  EXPECT_TRUE(Verified().verdict().good()) << "that of an earlier proof is gone";
}

TEST_F(ProofFolderTest, AMissedPulseIsNotGood) {
  Unmake(1, PointOutcome::kMissed);
  EXPECT_THAT(Reason(), HasSubstr("1 point was fired without a crack"));
}

TEST_F(ProofFolderTest, ASkippedPointIsNotGood) {
  Unmake(3, PointOutcome::kSkipped);
  EXPECT_THAT(Reason(), HasSubstr("1 point was skipped"));
}

TEST_F(ProofFolderTest, ADoubledPointIsNotGood) {
  cracks_mm_.push_back(plan_mm_[3]);
  ticks_.push_back(kFirstTick + 100);
  EXPECT_THAT(Reason(), HasSubstr("1 point was made twice"));
}

TEST_F(ProofFolderTest, AStrayCrackIsNotGood) {
  cracks_mm_.push_back({5, 5, 5});
  ticks_.push_back(kFirstTick + 100);
  EXPECT_THAT(Reason(), HasSubstr("1 crack belongs to no planned point"));
}

TEST_F(ProofFolderTest, ACrackBeyondTheToleranceIsNotGoodAndOneAtItIs) {
  cracks_mm_[2].y() += (kToleranceUm - 0.01) / 1000;
  EXPECT_TRUE(Verified().verdict().good());
  cracks_mm_[2].y() += 0.02 / 1000;
  EXPECT_THAT(Reason(), HasSubstr("20.01 um off"));
}

TEST_F(ProofFolderTest, APointFiredThroughAnEarlierCrackIsNotGood) {
  // The upper left point first: the lower one lies in the shadow right below it.
  std::swap(ticks_[0], ticks_[2]);
  const JobReport report = Verified();
  EXPECT_EQ(report.shadow_violations(), 1u);
  EXPECT_THAT(report.verdict().reasons(),
              ElementsAre(HasSubstr("1 point was fired through an earlier crack")));
}

TEST_F(ProofFolderTest, APlanWithTwoPointsTooNearIsNotGood) {
  frozen_.mutable_job()->mutable_discretization()->set_min_spacing_mm(0.41);
  EXPECT_THAT(Reason(), AllOf(HasSubstr("0.4000 mm apart"), HasSubstr("0.4100 mm")));
}

// What journal and glass do not agree on is never explained away.
TEST_F(ProofFolderTest, AJournalThatTheGlassContradictsIsNotGood) {
  outcomes_[0] = PointOutcome::kMissed;  // the crack is there
  Unmake(3, PointOutcome::kMade);        // and here it is not
  EXPECT_THAT(Reason(), HasSubstr("2 points are unaccounted for"));
}

TEST_F(ProofFolderTest, AnIntentWithoutAnOutcomeIsNotGood) {
  Unmake(3, PointOutcome::kNone);
  EXPECT_THAT(Reason(), HasSubstr("1 point is unaccounted for"));
}

// Whether it was fired before is as unknown as it was.
TEST_F(ProofFolderTest, AnUncertainPointThatWasNotFiredAgainIsUnaccountedFor) {
  Unmake(3, PointOutcome::kUncertain);
  reopened_ = {3};
  EXPECT_THAT(Reason(), HasSubstr("1 point is unaccounted for"));
}

TEST_F(ProofFolderTest, EveryReasonIsNamed) {
  Unmake(3, PointOutcome::kMissed);
  Unmake(1, PointOutcome::kSkipped);
  cracks_mm_.push_back({5, 5, 5});
  ticks_.push_back(kFirstTick + 100);
  const JobReport report = Verified();
  EXPECT_EQ(report.verdict().reasons_size(), 3);
  EXPECT_THAT(report.verdict().reasons(),
              UnorderedElementsAre(HasSubstr("skipped"), HasSubstr("without a crack"),
                                   HasSubstr("no planned point")));
}

TEST_F(ProofFolderTest, WhatIsNotThereOrNotWhatItShouldBeIsNamed) {
  for (const char* file : {"job.json", "path.ply", "glass.ply", "journal.bin"}) {
    WriteFolder();
    fs::remove(folder_ / file);
    // There is no glass of a real machine.
    const bool needed = std::string(file) != "glass.ply";
    const auto gone = VerifyFolder(folder_);
    ASSERT_EQ(gone.has_value(), !needed) << file;
    if (needed) {
      EXPECT_THAT(gone.error().message, HasSubstr((folder_ / file).string()));
    }
    std::ofstream(folder_ / file) << "nonsense";
    const auto nonsense = VerifyFolder(folder_);
    ASSERT_FALSE(nonsense) << file;
    EXPECT_THAT(nonsense.error().message, HasSubstr((folder_ / file).string()));
  }
  WriteFolder();
  fs::copy_file(folder_ / "path.ply", folder_ / "glass.ply",
                fs::copy_options::overwrite_existing);
  const auto no_tick = VerifyFolder(folder_);
  ASSERT_FALSE(no_tick);
  EXPECT_THAT(no_tick.error().message, HasSubstr("no column 'tick'"));
}

/// Two blocks: the upper layer in both, the lower in the second alone.
class ProofOfTwoBlocksTest : public ProofFolderTest {
 protected:
  ProofOfTwoBlocksTest() {
    JobSpec& job = *frozen_.mutable_job();
    job.mutable_laser()->add_channels(2);
    job.add_models()->add_channels(2);
    job.add_models();
    job.mutable_models(1)->add_channels(1);
    job.mutable_models(1)->add_channels(2);
    source_ = {0, 0, 1, 1};
    cracks_mm_ = {plan_mm_[0], plan_mm_[1], plan_mm_[2],
                  plan_mm_[2], plan_mm_[3], plan_mm_[3]};
    channels_ = {1, 1, 0, 1, 0, 1};
    ticks_ = {1000, 1002, 1004, 1004, 1006, 1006};
  }
};

TEST_F(ProofOfTwoBlocksTest, EachHoldsItsOwn) {
  const JobReport report = Verified();
  EXPECT_TRUE(report.verdict().good()) << report.verdict().ShortDebugString();
  EXPECT_EQ(report.points().made(), 4u);
  ASSERT_EQ(report.channels_size(), 2);
  EXPECT_EQ(report.channels(0).channel(), 1u);
  EXPECT_EQ(report.channels(0).planned(), 2u);
  EXPECT_EQ(report.channels(0).made(), 2u);
  EXPECT_EQ(report.channels(1).planned(), 4u);
  EXPECT_EQ(report.channels(1).made(), 4u);
}

TEST_F(ProofOfTwoBlocksTest, ACrackInTheWrongBlockIsStray) {
  channels_[0] = 0;
  const JobReport report = Verified();
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(report.points().stray(), 1u);
  EXPECT_EQ(report.points().unaccounted(), 1u) << "made, says the journal";
  EXPECT_EQ(report.channels(0).stray(), 1u);
  EXPECT_EQ(report.channels(1).made(), 3u);
}

TEST_F(ProofOfTwoBlocksTest, APointThatOneBlockLacksIsNotMade) {
  cracks_mm_.pop_back();
  ticks_.pop_back();
  const JobReport report = Verified();
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(report.points().made(), 3u);
  EXPECT_EQ(report.channels(0).made(), 2u);
  EXPECT_EQ(report.channels(1).made(), 3u);
}

// One above the other, in different blocks; then in the same.
TEST_F(ProofOfTwoBlocksTest, OnlyCracksOfTheSameBlockAreInTheWay) {
  frozen_.mutable_job()->mutable_models(1)->clear_channels();
  frozen_.mutable_job()->mutable_models(1)->add_channels(1);
  cracks_mm_ = {plan_mm_[2], plan_mm_[3], plan_mm_[0], plan_mm_[1]};
  channels_ = {0, 0, 1, 1};
  ticks_ = {1000, 1002, 1004, 1006};
  EXPECT_EQ(Verified().shadow_violations(), 0u);
  frozen_.mutable_job()->mutable_models(1)->set_channels(0, 2);
  channels_ = {1, 1, 1, 1};
  EXPECT_EQ(Verified().shadow_violations(), 2u);
}

TEST_F(ProofFolderTest, IsMadeFromTheCellsFilesAndReadsBackTheSame) {
  const fs::path cell = folder_ / "cell";
  fs::create_directories(cell);
  WriteJob(cell);
  WriteJournal(cell / "journal.bin");
  formats::PointTable plan;
  plan.points_mm = plan_mm_;
  plan.columns = {{"source", source_}};
  ASSERT_TRUE(formats::WritePly(cell / "path.ply", plan));
  std::vector<std::byte> record =
      formats::EncodeGlassHeader({Vec3(20, 20, 20), 1.5, 0.1});
  for (std::size_t i = 0; i < cracks_mm_.size(); ++i) {
    formats::AppendGlassCrack(
        {static_cast<std::uint64_t>(ticks_[i]), cracks_mm_[i], 30, 0, true}, record);
  }
  // A pulse into the air marks nothing.
  formats::AppendGlassCrack({kFirstTick + 50, Vec3(1, 1, 30), 30, 0, false}, record);
  std::ofstream(cell / "glass.rec", std::ios::binary)
      .write(reinterpret_cast<const char*>(record.data()),
             static_cast<std::streamsize>(record.size()));

  ProofInputs inputs;
  inputs.folder = folder_;
  inputs.job_folder = cell;
  inputs.glass_record = cell / "glass.rec";
  inputs.warnings = {MakeWarning(WarningCode::kChosen, "a note")};
  const auto made = MakeProof(inputs);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(made->verdict().good()) << made->verdict().ShortDebugString();
  ASSERT_EQ(made->warnings_size(), 1);
  EXPECT_EQ(made->warnings(0).text(), "a note");
  EXPECT_GT(fs::file_size(folder_ / "views.png"), 1000u);
  const auto verified = VerifyFolder(folder_);
  ASSERT_TRUE(verified);
  EXPECT_EQ(verified->report.verdict().ShortDebugString(),
            made->verdict().ShortDebugString());
  EXPECT_EQ(verified->report.checksums().at("glass"), made->checksums().at("glass"));

  std::ifstream in(folder_ / "report.json");
  const std::string json((std::istreambuf_iterator<char>(in)), {});
  JobReport read;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(json, &read).ok());
  EXPECT_EQ(read.SerializeAsString().size(), made->SerializeAsString().size());
  EXPECT_THAT(json, HasSubstr("\"doubled\": \"0\"")) << "zeros are written out";

  // A warning of weight is a verdict of its own, and verify keeps to it.
  inputs.warnings.push_back(MakeWarning(WarningCode::kOddRays, "3 of 9 rays"));
  inputs.breakage_accepted_by = "ann@shop";
  const auto warned = MakeProof(inputs);
  ASSERT_TRUE(warned);
  EXPECT_FALSE(warned->verdict().good());
  EXPECT_EQ(warned->verdict().kind(), "good_with_warnings");
  EXPECT_THAT(warned->verdict().reasons(), ElementsAre("3 of 9 rays"));
  const auto again = VerifyFolder(folder_);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->report.verdict().ShortDebugString(),
            warned->verdict().ShortDebugString());
  EXPECT_EQ(again->report.breakage_accepted_by(), "ann@shop");
}

TEST_F(ProofFolderTest, WithoutTheGlassThePointsCountByTheController) {
  outcomes_[2] = PointOutcome::kMissed;
  WriteFolder();
  fs::remove(folder_ / "glass.ply");
  const auto proved = VerifyFolder(folder_);
  ASSERT_TRUE(proved) << proved.error().message;
  const JobReport& report = proved->report;
  EXPECT_EQ(report.evidence(), "controller");
  EXPECT_EQ(report.points().planned(), 4u);
  EXPECT_EQ(report.points().made(), 3u);
  EXPECT_EQ(report.points().missed(), 1u);
  EXPECT_EQ(report.ticks(), 7u) << "from tick 1000 to 1006";
  EXPECT_EQ(report.position_errors().max_um(), 0);
  EXPECT_FALSE(report.checksums().contains("glass"));
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(Verified().evidence(), "glass");
}

// What the glass has shown is not forgotten because its record is missing.
TEST_F(ProofFolderTest, AReportThatTheGlassProvedIsNotRepeatedByCountersAlone) {
  WriteFolder();
  ASSERT_TRUE(CompleteFolder({folder_, {}, false}));
  const fs::path glass = folder_ / "glass.ply", away = folder_ / "away.ply";
  fs::rename(glass, away);
  auto proved = VerifyFolder(folder_);
  ASSERT_TRUE(proved);
  EXPECT_EQ(proved->report.verdict().kind(), "good_with_warnings");
  EXPECT_THAT(
      proved->report.verdict().reasons(),
      ElementsAre(HasSubstr("report.json was proved by the glass, whose record")));
  // It is not written over, and is good again with its record.
  proved = CompleteFolder({folder_, {}, true});
  ASSERT_TRUE(proved && proved->not_written);
  EXPECT_THAT(proved->not_written->message, HasSubstr("not renewed"));
  fs::rename(away, glass);
  EXPECT_EQ(Verified().verdict().kind(), "good");

  cracks_mm_.pop_back();
  ticks_.pop_back();
  WriteFolder();
  ASSERT_TRUE(CompleteFolder({folder_, {}, true}));
  fs::remove(glass);
  proved = VerifyFolder(folder_);
  ASSERT_TRUE(proved);
  EXPECT_EQ(proved->report.verdict().kind(), "not_good") << "the journal is content";
  EXPECT_GE(proved->report.verdict().reasons_size(), 2);
}

TEST_F(ProofFolderTest, UnknownPointsOfARealMachineAreNotGood) {
  outcomes_[1] = PointOutcome::kUncertain;
  outcomes_[3] = PointOutcome::kNone;  // an intent without an outcome
  WriteFolder();
  fs::remove(folder_ / "glass.ply");
  const auto proved = VerifyFolder(folder_);
  ASSERT_TRUE(proved);
  EXPECT_EQ(proved->report.points().made(), 2u);
  EXPECT_EQ(proved->report.points().unaccounted(), 2u);
  EXPECT_THAT(proved->report.verdict().reasons(),
              ElementsAre(HasSubstr("unknown whether 2 points were fired")));
}

TEST_F(ProofFolderTest, AFolderIsCompletedWithWhatIsMissing) {
  WriteFolder();
  ASSERT_TRUE(CompleteFolder({folder_, {}, false}));
  EXPECT_TRUE(fs::exists(folder_ / "views.png"));
  const auto read = [&] {
    std::ifstream in(folder_ / "report.json");
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  EXPECT_THAT(read(), HasSubstr("\"evidence\": \"glass\""));
  // What is there stays, unless it is to be renewed.
  const auto size = fs::file_size(folder_ / "views.png");
  std::ofstream(folder_ / "views.png") << "mine";
  ASSERT_TRUE(CompleteFolder({folder_, {}, false}));
  EXPECT_EQ(fs::file_size(folder_ / "views.png"), 4u);
  ASSERT_TRUE(CompleteFolder({folder_, {}, true}));
  EXPECT_EQ(fs::file_size(folder_ / "views.png"), size);
}

TEST_F(ProofFolderTest, StagesAndStatisticsOfAShopAreInTheReport) {
  WriteFolder();
  std::ofstream(folder_ / "stages.json")
      << R"({"job_number": 7, "engrave": {"engrave": {"made_count": 4,
             "estimate_ticks": 900, "plan_checksum": "ab"}},
             "warnings": [{"code": "odd_rays", "weight": "warning", "text": "rays"}]})";
  std::ofstream(folder_ / "statistics.json")
      << R"({"job": 7, "state": "done", "ended_utc": "2026-11-23T08:12:34.000Z",
             "a_newer_field": 1})";
  const auto proved = CompleteFolder({folder_, {}, false});
  ASSERT_TRUE(proved);
  EXPECT_EQ(proved->report.job_number(), 7u);
  EXPECT_EQ(proved->report.engrave().made_count(), 4u);
  EXPECT_EQ(proved->report.estimated_time_s(), 9);
  EXPECT_EQ(proved->report.ended_utc(), "2026-11-23T08:12:34.000Z");
  EXPECT_EQ(proved->report.verdict().kind(), "good_with_warnings");
  // From now on the report has it.
  fs::remove(folder_ / "stages.json");
  fs::remove(folder_ / "statistics.json");
  const auto again = CompleteFolder({folder_, {}, true});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->report.SerializeAsString().size(),
            proved->report.SerializeAsString().size());
}

TEST_F(ProofFolderTest, TheFoldersOfAShopsJobsAreFound) {
  const fs::path jobs = folder_ / "jobs";
  for (const char* job : {"2-b", "1-a", "3-never-engraved"}) {
    fs::create_directories(jobs / job);
    std::ofstream(jobs / job / "statistics.json") << "{}";
  }
  std::ofstream(jobs / "1-a" / "journal.bin") << "x";
  std::ofstream(jobs / "2-b" / "journal.bin") << "x";
  EXPECT_THAT(JobFoldersIn(jobs), ElementsAre(jobs / "1-a", jobs / "2-b"));
  WriteFolder();
  EXPECT_TRUE(JobFoldersIn(folder_).empty()) << "it is a job's own folder";
  EXPECT_TRUE(JobFoldersIn(folder_ / "none").empty());
}

TEST_F(ProofFolderTest, AJobThatIsBeingEngravedGetsNoReport) {
  outcomes_.back() = PointOutcome::kNone;
  cracks_mm_.pop_back();
  ticks_.pop_back();
  WriteFolder();
  std::ofstream(folder_ / "statistics.json") << R"({"job": 7, "state": "engraving"})";
  const auto proved = CompleteFolder({folder_, {}, true});
  ASSERT_TRUE(proved);
  EXPECT_THAT(proved->report.verdict().reasons(),
              Contains(HasSubstr("the job has not ended")));
  EXPECT_FALSE(fs::exists(folder_ / "report.json"));
  EXPECT_FALSE(fs::exists(folder_ / "views.png"));
}

TEST_F(ProofFolderTest, WhatCannotBeWrittenIsNamedAndTheVerdictIsThere) {
  WriteFolder();
  fs::create_directory(folder_ / "views.png");  // in the way, for root as well
  std::ofstream(folder_ / "views.png" / "x") << "x";
  const auto proved = CompleteFolder({folder_, {}, true});
  ASSERT_TRUE(proved);
  EXPECT_TRUE(proved->report.verdict().good());
  ASSERT_TRUE(proved->not_written);
  EXPECT_THAT(proved->not_written->message, HasSubstr("views.png"));
  EXPECT_FALSE(fs::exists(folder_ / "report.json")) << "it is not complete";
}

// The report is from before warnings had a weight.
TEST_F(ProofFolderTest, SentencesOfAnOlderReportAreNotes) {
  std::ofstream(folder_ / "report.json") << R"({"warnings": ["the model is open"]})";
  const JobReport report = Verified();
  ASSERT_EQ(report.warnings_size(), 1);
  EXPECT_EQ(report.warnings(0).weight(), "note");
  EXPECT_EQ(report.warnings(0).text(), "the model is open");
  EXPECT_TRUE(report.verdict().good());
  std::ofstream(folder_ / "report.json") << "{";
  EXPECT_EQ(Verified().warnings_size(), 0);
}

}  // namespace
}  // namespace intaglio::client
