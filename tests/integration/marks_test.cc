// Jobs of marks through all processes of a shop whose machine is the virtual scan head.
// The judge is the record of its material: which mark was burnt in which run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/mark_record.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using formats::PointOutcome;
using testing::Eventually;
using testing::Program;
using testing::Running;

constexpr std::uint32_t kColumns = 20, kRows = 10, kMarks = kColumns * kRows;
constexpr auto kBound = 150s;

struct MarkJudgement {
  std::size_t burnt = 0, doubled = 0, made = 0, uncertain = 0;
  std::size_t unknown = 0;   ///< burnt, and neither made nor uncertain
  std::size_t not_made = 0;  ///< made by the journal, and not burnt
};

class MarkShop : public ::testing::Test {
 protected:
  MarkShop() : folder_(test::FreshFolder()), tag_("marks" + std::to_string(getpid())) {
    std::ofstream drawing(folder_ / "circles.svg");
    drawing << R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" )"
            << R"(viewBox="0 0 40 20">)";
    for (std::uint32_t i = 0; i < kMarks; ++i) {
      drawing << "<circle cx=\"" << 1 + 2 * (i % kColumns) << "\" cy=\""
              << 1 + 2 * (i / kColumns) << "\" r=\"0.5\"/>";
    }
    drawing << "</svg>";
    std::ofstream(folder_ / "job.textproto")
        << "name: \"circles\"\nmachine_file: \"shop/machine.textproto\"\n"
        << "marks { items { drawing { file: \"circles.svg\" } } "
        << "pen { speed_mm_s: 200 power_ratio: 0.5 } }\n";
    fs::create_directory(folder_ / "shop");
    fs::copy_file(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo.textproto",
                  folder_ / "shop/machine.textproto");
  }
  ~MarkShop() override {
    if (!IsOpen()) return;
    up_->Signal(SIGTERM);
    up_->WaitForEnd(20s);
  }

  bool IsOpen() { return up_ && up_->running(); }
  bool Open() {
    up_.reset();
    up_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--folder", (folder_ / "shop").string(), "--materials",
              (folder_ / "materials.db").string(), "--machine",
              (folder_ / "shop/machine.textproto").string()}),
        folder_ / ("up" + std::to_string(++opened_) + ".log"));
    return Eventually(
               [this] { return !up_->running() || HasPrinted("the shop is open"); },
               60s) &&
           up_->running();
  }
  bool HasPrinted(const std::string& text) const {
    return up_->Output().find(text) != std::string::npos;
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", "49", "--tag", tag_});
    return words;
  }
  std::string Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words), folder_ / "typed.txt");
    return run.WaitForEnd(60s).output;
  }
  bool Submit() {
    return Type({"submit", (folder_ / "job.textproto").string(), "--arm"})
               .find("job 1") != std::string::npos;
  }
  /// A paused job is resumed, a shop that was closed by too many kills opened again.
  bool AwaitDone() {
    return Eventually(
        [&] {
          if (!IsOpen() && !Open()) return false;
          shown_ = Type({"show", "1"});
          if (shown_.find("state      paused") != std::string::npos)
            Type({"resume", "1"});
          return shown_.find("state      done") != std::string::npos;
        },
        kBound);
  }
  void Kill(const std::string& service) const {
    for (const pid_t process : testing::ProcessesWith({"/" + service, tag_}))
      kill(process, SIGKILL);
  }
  std::size_t BurntTicks() const {
    const auto record = formats::ReadMarkRecord(folder_ / "shop/marks.rec");
    return record ? record->ticks.size() : 0;
  }

  MarkJudgement Judge() const {
    MarkJudgement judgement;
    std::map<std::uint32_t, std::set<std::pair<fs::path, std::uint32_t>>> runs_of;
    for (const fs::path& file : Records()) {
      const auto record = formats::ReadMarkRecord(file);
      EXPECT_TRUE(record) << file;
      if (!record) continue;
      for (const formats::BurntTick& tick : record->ticks)
        runs_of[tick.mark].insert({file, tick.run});
    }
    const auto outcomes = LastOutcomes();
    judgement.burnt = runs_of.size();
    for (std::uint32_t mark = 0; mark < kMarks; ++mark) {
      const bool burnt = runs_of.contains(mark);
      const PointOutcome outcome = outcomes.at(mark);
      judgement.doubled += burnt && runs_of.at(mark).size() > 1;
      judgement.made += outcome == PointOutcome::kMade;
      judgement.uncertain += outcome == PointOutcome::kUncertain;
      judgement.unknown +=
          burnt && outcome != PointOutcome::kMade && outcome != PointOutcome::kUncertain;
      judgement.not_made += !burnt && outcome == PointOutcome::kMade;
    }
    return judgement;
  }

  fs::path folder_;
  std::string tag_, shown_;
  int opened_ = 0;
  std::unique_ptr<Running> up_;

 private:
  /// Of this and of earlier openings of the shop.
  std::vector<fs::path> Records() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / "shop"))
      if (entry.path().filename().string().starts_with("marks"))
        files.push_back(entry.path());
    return files;
  }
  std::vector<PointOutcome> LastOutcomes() const {
    std::vector<PointOutcome> last(kMarks, PointOutcome::kNone);
    for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
      if (!entry.path().filename().string().starts_with("1-")) continue;
      const auto journal = formats::ReadJournal(entry.path() / "journal.bin");
      EXPECT_TRUE(journal);
      if (!journal) continue;
      for (const formats::JournalRecord& one : journal->records)
        if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
    }
    return last;
  }
};

TEST_F(MarkShop, MakesEachMarkOnce) {
  ASSERT_TRUE(Open()) << up_->Output();
  ASSERT_TRUE(Submit());
  ASSERT_TRUE(AwaitDone()) << shown_ << up_->Output();
  const MarkJudgement judgement = Judge();
  EXPECT_EQ(judgement.burnt, kMarks);
  EXPECT_EQ(judgement.doubled, 0u);
  EXPECT_EQ(judgement.unknown + judgement.not_made, 0u);
  // A computer that is busy for 250 ms ends the beam in mid-mark, as it should.
  EXPECT_EQ(judgement.made + judgement.uncertain, kMarks);
}

TEST_F(MarkShop, APauseEndsTheMarkInHand) {
  ASSERT_TRUE(Open()) << up_->Output();
  ASSERT_TRUE(Submit());
  ASSERT_TRUE(Eventually([&] { return BurntTicks() > 5000; }, 60s));
  Type({"pause", "1"});
  ASSERT_TRUE(AwaitDone()) << shown_ << up_->Output();
  const MarkJudgement judgement = Judge();
  EXPECT_EQ(judgement.burnt, kMarks);
  EXPECT_EQ(judgement.doubled + judgement.unknown + judgement.not_made, 0u);
}

// INTAGLIO_MARK_KILLS: of each process, one unless it is set.
class KilledMarkService : public MarkShop,
                          public ::testing::WithParamInterface<const char*> {};

TEST_P(KilledMarkService, NoMarkIsMadeTwiceAndNoneIsUnknown) {
  const char* const asked = std::getenv("INTAGLIO_MARK_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 1;
  std::mt19937 random(7);
  ASSERT_TRUE(Open()) << up_->Output();
  ASSERT_TRUE(Submit());
  for (int i = 0; i < kills; ++i) {
    std::this_thread::sleep_for(
        std::chrono::milliseconds(std::uniform_int_distribution(0, 2500)(random)));
    Kill(GetParam());
    if (i + 1 < kills && shown_.find("state      paused") != std::string::npos)
      Type({"resume", "1"});
    shown_ = Type({"show", "1"});
    if (shown_.find("state      done") != std::string::npos) break;
  }
  ASSERT_TRUE(AwaitDone()) << shown_ << up_->Output();
  const MarkJudgement judgement = Judge();
  EXPECT_EQ(judgement.doubled, 0u);
  EXPECT_EQ(judgement.unknown, 0u);
  EXPECT_EQ(judgement.not_made, 0u);
  EXPECT_EQ(judgement.made + judgement.uncertain, kMarks);
  RecordProperty("uncertain", std::to_string(judgement.uncertain));
}

INSTANTIATE_TEST_SUITE_P(EveryService, KilledMarkService,
                         ::testing::Values("intaglio-job-service", "intaglio-discretizer",
                                           "intaglio-sorter", "intaglio-marker"),
                         [](const auto& service) {
                           std::string name = service.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace intaglio
