// Recordings that were cut, or that leave topics out: the same synchronizer never differs
// from them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

/// What the synchronizer gets and what it sends, in one of these recordings.
const std::vector<std::string> kTopics = {
    "EngraveTask", "Interlock",          "LampSync",   "MotionState",
    "PathBatch",   "MotionSegmentBatch", "Permission", "PulseEventBatch",
    "TaskStatus",  "ServiceHealth"};

class ReplayOfCut : public ::testing::Test {
 protected:
  testing::Ended Type(const std::vector<std::string>& words) {
    testing::Running run(testing::Program("intaglio"), words, folder_ / "output.txt");
    return run.WaitForEnd(120s);
  }
  testing::Ended Against(const std::string& recording, std::vector<std::string> options) {
    const fs::path cut = folder_ / "cut.mcap";
    fs::remove(cut);
    std::vector<std::string> words = {
        "recording", "cut",
        INTAGLIO_SOURCE_DIR "/tests/data/recordings/" + recording + ".mcap", "--out",
        cut};
    words.insert(words.end(), options.begin(), options.end());
    const testing::Ended made = Type(words);
    EXPECT_EQ(made.exit_code, 0) << made.output;
    return Type({"replay", cut, "--against", "synchronizer"});
  }

  fs::path folder_ = test::FreshFolder();
};

// One was paused and resumed by a person: the cuts lie before the first pulse, in the
// first run, in the pause, and in the run after it.
TEST_F(ReplayOfCut, IsIdenticalAsFarAsItGoes) {
  for (const auto& [to_s, compared] :
       {std::pair("1.5", "1 run, 704 segments, 0 points"),
        std::pair("2.5", "1 run, 704 segments, 26 points"),
        std::pair("3.8", "1 run, 704 segments, 81 points"),
        std::pair("5.2", "2 runs, 1 272 segments, 81 points"),
        std::pair("6", "2 runs, 1 272 segments, 111 points")}) {
    SCOPED_TRACE(to_s);
    const testing::Ended ended = Against("paused", {"--to", to_s});
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr(compared));
    EXPECT_THAT(ended.output, HasSubstr("the recording ends there"));
  }
}

TEST_F(ReplayOfCut, WithoutATopicThatIsNeededIsNotComparable) {
  for (const std::string recording : {"paused", "silent"}) {
    for (const std::string left_out : {"LampSync", "MotionState", "MotionSegmentBatch",
                                       "Permission", "PulseEventBatch"}) {
      SCOPED_TRACE(recording + " without " + left_out);
      std::vector<std::string> options = {"--topic"};
      for (const std::string& topic : kTopics) {
        if (topic != left_out) options.push_back(topic);
      }
      const testing::Ended ended = Against(recording, options);
      EXPECT_EQ(ended.exit_code, 3) << ended.output;
      EXPECT_THAT(ended.output, HasSubstr("NOT COMPARABLE"));
      EXPECT_THAT(ended.output, HasSubstr("the recording has no " + left_out));
      EXPECT_THAT(ended.output, Not(HasSubstr("DIFFERENT")));
    }
  }
}

}  // namespace
}  // namespace intaglio
