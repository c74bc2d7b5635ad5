// Whose block a program fires into, for points and for marks, in shops of real processes:
// the judge is the record of the machine, which knows every crack and every mark.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <memory>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/mark_record.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;

class BlockShop : public ::testing::Test {
 protected:
  ~BlockShop() override {
    for (auto* process : {batch_.get(), up_.get()}) {
      if (process == nullptr || !process->running()) continue;
      process->Signal(SIGINT);
      process->WaitForEnd(20s);
    }
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(),
                 {"--domain", "48", "--tag", "blocks" + std::to_string(getpid())});
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words), folder_ / "typed.txt");
    return run.WaitForEnd(60s);
  }
  void Open(std::vector<std::string> words) {
    setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
    words.insert(words.begin(), {"up", "--folder", shop_.string()});
    up_ = std::make_unique<Running>(Program("intaglio"), With(std::move(words)),
                                    folder_ / "up.txt");
    ASSERT_TRUE(Eventually(
        [this] { return up_->Output().find("the shop is open") != std::string::npos; },
        60s))
        << up_->Output();
  }
  /// What the newest `show` of the job has.
  bool Shows(const std::string& job, const std::string& text) {
    shown_ = Type({"show", job}).output;
    return shown_.find(text) != std::string::npos;
  }
  bool Reaches(const std::string& job, const std::string& text) {
    return Eventually([&] { return Shows(job, text); }, 90s);
  }
  std::size_t Cracks() const {
    const auto record = formats::ReadGlassRecord(shop_ / "glass.rec");
    return record ? record->cracks.size() : 0;
  }
  std::size_t Marks() const {
    const auto record = formats::ReadMarkRecord(shop_ / "marks.rec");
    return record ? record->ticks.size() : 0;
  }

  fs::path folder_ = test::FreshFolder(), shop_ = folder_ / "shop";
  std::unique_ptr<Running> up_, batch_;
  std::string shown_;
};

class TwoBlocks : public BlockShop {
 protected:
  void OpenPoints() {
    std::ofstream(folder_ / "two.csv")
        << "id,models[0].placement.fit_height_mm\nfirst,4\nsecond,4\n";
    Open({"--speed", "10", "--warm-up", "0", "--block", "50", "50", "30"});
  }
  void OpenMarks() {
    std::ofstream(folder_ / "ring.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="10mm" height="10mm" )"
           R"(viewBox="0 0 10 10"><circle cx="5" cy="5" r="4"/></svg>)";
    std::ofstream(folder_ / "ring.textproto")
        << "name: \"ring\"\nmachine_file: \"" INTAGLIO_SOURCE_DIR
           "/deploy/machines/galvo.textproto\"\n"
           "marks { items { drawing { file: \"ring.svg\" } } }\n";
    std::ofstream(folder_ / "two.csv") << "id,name\nfirst,ring 1\nsecond,ring 2\n";
    Open({"--machine", "galvo", "--speed", "1"});
  }
  void Batch(const std::vector<std::string>& more) {
    const fs::path ring = folder_ / "ring.textproto";
    std::vector<std::string> words = {"batch", (folder_ / "two.csv").string(), "--job",
                                      fs::exists(ring) ? ring.string()
                                                       : INTAGLIO_SOURCE_DIR
                                          "/deploy/jobs/sample.textproto",
                                      "--events"};
    words.insert(words.end(), more.begin(), more.end());
    batch_ = std::make_unique<Running>(Program("intaglio"), With(std::move(words)),
                                       folder_ / "batch.txt");
  }
};

class TwoOfABatch : public TwoBlocks, public ::testing::WithParamInterface<bool> {
 protected:
  std::size_t Made() const { return GetParam() ? Marks() : Cracks(); }
};

// The second job was armed 68 ms after the first had ended, and all of its points were
// fired into the first's block.
TEST_P(TwoOfABatch, TheSecondJobWaitsUntilTheMachineWasOpenedAndClosed) {
  ASSERT_NO_FATAL_FAILURE(GetParam() ? OpenMarks() : OpenPoints());
  Batch({"--arm"});
  ASSERT_TRUE(Reaches("1", "state      done")) << shown_ << batch_->Output();
  const std::size_t first = Made();
  EXPECT_GT(first, 0u);
  ASSERT_TRUE(Reaches("2", "state      waiting for arm")) << shown_;
  EXPECT_FALSE(Eventually([&] { return Made() != first; }, 4s));
  EXPECT_THAT(batch_->Output(), HasSubstr("waits for a person: neither key nor door of"));
  EXPECT_THAT(batch_->Output(), HasSubstr("\"awaits_block\":true"));
  testing::AskPanel(shop_, "door open");
  EXPECT_FALSE(Eventually([&] { return Made() != first; }, 2s));
  EXPECT_FALSE(Shows("2", "armed\n")) << shown_;
  testing::AskPanel(shop_, "door close");
  const Ended ended = batch_->WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(Made(), 2 * first);
}

INSTANTIATE_TEST_SUITE_P(, TwoOfABatch, ::testing::Bool(), [](const auto& row) {
  return row.param ? "OfMarks" : "OfPoints";
});

// The same rule for a machine that marks: an arm that was typed before the piece in front
// was made says nothing of the piece that comes after it.
TEST_F(TwoBlocks, AMarkJobBehindAnotherOneIsNotArmedForItsPiece) {
  ASSERT_NO_FATAL_FAILURE(OpenMarks());
  const std::string job = (folder_ / "ring.textproto").string();
  ASSERT_EQ(Type({"submit", job}).exit_code, 0);
  ASSERT_TRUE(Reaches("1", "state      waiting for arm")) << shown_;
  batch_ = std::make_unique<Running>(
      Program("intaglio"), With({"submit", job, "--arm", "--watch"}), folder_ / "2.txt");
  ASSERT_TRUE(Reaches("2", "state      queued")) << shown_;
  ASSERT_EQ(Type({"arm", "1"}).exit_code, 0);
  ASSERT_TRUE(Reaches("1", "state      done")) << shown_;
  const std::size_t first = Marks();
  EXPECT_GT(first, 0u);
  const Ended left = batch_->WaitForEnd(30s);
  EXPECT_EQ(left.exit_code, 4) << left.output;
  EXPECT_THAT(left.output, HasSubstr("job 2 is not armed by a program"));
  EXPECT_FALSE(Eventually([&] { return Marks() != first; }, 2s));
  // A person has checked which piece is in.
  ASSERT_EQ(Type({"arm", "2"}).exit_code, 0);
  ASSERT_TRUE(Reaches("2", "state      done")) << shown_;
  EXPECT_GT(Marks(), first);
}

TEST_F(TwoBlocks, SameBlockArmsThemOneAfterTheOther) {
  ASSERT_NO_FATAL_FAILURE(OpenPoints());
  Batch({"--arm", "--same-block"});
  const Ended ended = batch_->WaitForEnd(90s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, Not(HasSubstr("waits for a person")));
}

// Block identity, present, done: docs/jobs.md.
TEST_F(TwoBlocks, ALoaderArmsEachJobWithABlockThatNoOtherJobHad) {
  ASSERT_NO_FATAL_FAILURE(OpenPoints());
  Batch({});
  const auto arms = [this](const std::string& job, const std::string& block) {
    return Type({"arm", job, "--loaded", block});
  };
  ASSERT_TRUE(Eventually([&] { return arms("1", "B-17").exit_code == 0; }, 60s));
  ASSERT_TRUE(Reaches("1", "state      done")) << shown_;
  ASSERT_TRUE(Reaches("2", "state      waiting for arm")) << shown_;
  const Ended again = arms("2", "B-17");
  EXPECT_EQ(again.exit_code, 4) << again.output;
  EXPECT_THAT(again.output, HasSubstr("refused, same_block: the block B-17"));
  const Ended armed = arms("2", "B-18");
  EXPECT_EQ(armed.exit_code, 0) << armed.output;
  const Ended ended = batch_->WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("\"block_id\":\"B-18\""));
}

// ---- What is mounted -----------------------------------------------------------------

class MountShop : public BlockShop {};

TEST_F(MountShop, AMountIsReportedWithoutClosingTheShopAndEndsTheArm) {
  ASSERT_NO_FATAL_FAILURE(
      Open({"--speed", "1", "--warm-up", "20", "--block", "50", "50", "30"}));
  const Ended submitted =
      Type({"submit", INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--height",
            "5", "--block", "60", "55", "20"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
  ASSERT_TRUE(Reaches("1", "state      waiting for arm")) << shown_;
  EXPECT_THAT(shown_, HasSubstr("for a block of 60 x 55 x 20 mm"));
  const Ended other = Type({"arm", "1"});
  EXPECT_EQ(other.exit_code, 4) << other.output;
  EXPECT_THAT(other.output, HasSubstr("refused, not_mounted"));
  EXPECT_THAT(other.output,
              HasSubstr("intaglio mount --machine els-03 --block 60 55 20"));

  const Ended mounted = Type({"mount", "--block", "60", "55", "20"});
  EXPECT_EQ(mounted.exit_code, 0) << mounted.output;
  EXPECT_THAT(mounted.output, HasSubstr("els-03: 60 x 55 x 20 N-BK7, f43"));
  const Ended armed = Type({"arm", "1"});
  EXPECT_EQ(armed.exit_code, 0) << armed.output;
  EXPECT_THAT(armed.output, HasSubstr("60 x 55 x 20 N-BK7, f43: armed"));
  EXPECT_THAT(Type({"status"}).output,
              ::testing::ContainsRegex("mounted    els-03     60 x 55 x 20 N-BK7, f43 "
                                       "\\(.*@.*, 20.*Z\\)"));

  // The same parts are another block: the arm of the one before ends.
  EXPECT_EQ(Type({"teach", "mount", "--block", "60", "55", "20"}).exit_code, 0);
  ASSERT_TRUE(Reaches("1", "has reported what is mounted, 60 x 55 x 20")) << shown_;
  EXPECT_FALSE(Shows("1", "armed\n")) << shown_;
  EXPECT_EQ(Cracks(), 0u);
}

}  // namespace
}  // namespace intaglio
