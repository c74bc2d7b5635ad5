// Recordings that leave out bulk by request are small, and report what they lack wherever
// it is missed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/formats/point_file.h"
#include "proto/recording.pb.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::Ended;
using ::testing::HasSubstr;
using testing::kBound;
using ::testing::Not;
using testing::Program;
using testing::RunJob;
using testing::Running;

constexpr char kByRequest[] = "leaves out bulk topics by request";

class BulkRecording : public RunJob {
 protected:
  /// Records the sample with these options; the size of the recording.
  std::uintmax_t Record(const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--lockstep", "--warm-up", "0", "--spacing", "0.3"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended run = Run(words);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return fs::file_size(Recording());
  }
  Ended Type(const std::vector<std::string>& words) {
    Running typed(Program("intaglio"), words, folder_ / "typed.txt");
    return typed.WaitForEnd(kBound);
  }
  RecordingInfo Info() {
    const Ended typed = Type({"recording", "info", "--json", Recording()});
    RecordingInfo info;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(typed.output, &info).ok())
        << typed.output;
    return info;
  }
  std::string Recording() const { return folder_ / "out/session.mcap"; }
};

TEST_F(BulkRecording, IsATenthOfTheSizeWithoutBulkAndASixthWhenThinned) {
  const auto all = Record({});
  EXPECT_EQ(Info().bulk().bulk(), "all");
  const auto thin = Record({"--bulk", "thin"});
  EXPECT_EQ(Info().bulk().bulk(), "thin");
  EXPECT_EQ(Info().bulk().one_of(), 10u);
  const auto none = Record({"--bulk", "none"});
  EXPECT_EQ(Info().bulk().bulk(), "none");
  EXPECT_LT(none, thin);
  EXPECT_LT(6 * thin, all * 2) << "small jobs have much state for few points";
  EXPECT_LT(none * 4, all);
  RecordProperty("bytes", std::to_string(all) + " " + std::to_string(thin) + " " +
                              std::to_string(none));
}

TEST_F(BulkRecording, ReportsWhatItLacksWhereverItIsMissed) {
  Record({"--bulk", "none"});
  const RecordingInfo info = Info();
  EXPECT_EQ(info.bulk().left_out_size(), 7);
  EXPECT_EQ(info.missing_size(), 0) << "nothing was lost";
  EXPECT_THAT(Type({"recording", "info", Recording()}).output,
              HasSubstr("left out    by request (--bulk none): ModelChunk, PointBatch"));
  EXPECT_THAT(Type({"recording", "list", Recording()}).output,
              AllOf(HasSubstr("by request (--bulk none)"), HasSubstr("\nPulseEventBatch"),
                    Not(HasSubstr("\nPathBatch"))));
  const Ended table = Type(
      {"recording", "export", Recording(), "--topic", "PathBatch", "--format", "csv"});
  EXPECT_EQ(table.exit_code, 2);
  EXPECT_THAT(table.output, HasSubstr(kByRequest));
  const Ended against = Type({"replay", Recording(), "--against", "sorter"});
  EXPECT_EQ(against.exit_code, 2);
  EXPECT_THAT(against.output, AllOf(HasSubstr(kByRequest), HasSubstr("--bulk all")));
  const Ended replay = Type({"replay", Recording(), "--fast", "--topic", "JobStatus",
                             "--tag", folder_.filename().string()});
  EXPECT_EQ(replay.exit_code, 0) << replay.output;
  EXPECT_THAT(replay.output, HasSubstr(kByRequest));
}

// The outcomes of all pulses are there; the places are in the job's folder.
TEST_F(BulkRecording, GivesTheCracksWithThePathOfTheJob) {
  Record({"--bulk", "none"});
  const std::string cracks = folder_ / "cracks.ply";
  const Ended alone =
      Type({"recording", "export", Recording(), "--format", "ply", "--out", cracks});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.output, AllOf(HasSubstr(kByRequest), HasSubstr("--path")));
  const fs::path path = folder_ / "out/path.ply";
  const Ended with_path = Type({"recording", "export", Recording(), "--format", "ply",
                                "--out", cracks, "--path", path});
  ASSERT_EQ(with_path.exit_code, 0) << with_path.output;
  EXPECT_EQ(formats::ReadPly(cracks)->points_mm.size(),
            formats::ReadPly(path)->points_mm.size());
}

TEST_F(BulkRecording, IsRefusedWithAnotherChoice) {
  const Ended typed = Type({"record", "--bulk", "thick"});
  EXPECT_EQ(typed.exit_code, 2);
  EXPECT_THAT(typed.output, HasSubstr("did you mean thin?"));
}

}  // namespace
}  // namespace intaglio
