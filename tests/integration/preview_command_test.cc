// `intaglio preview` as a person types it: a job file, models, the job of a shop.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <fstream>

#include "proto/preview.pb.h"
#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::Ended;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;
using testing::TextIn;
using Tokens = std::vector<std::string>;

const std::string kSample =
    (fs::path(INTAGLIO_SOURCE_DIR) / "deploy/jobs/sample.textproto").string();
const std::string kKnot =
    (fs::path(INTAGLIO_SOURCE_DIR) / "deploy/jobs/sample.obj").string();

class PreviewCommand : public ::testing::Test {
 protected:
  Ended Type(Tokens words) {
    words.insert(words.end(), {"--materials", (folder_ / "materials.db").string()});
    Running run(Program("intaglio"), words,
                folder_ / (words.front() + std::to_string(++count_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  JobPreview Figures(const std::string& folder) const {
    JobPreview figures;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    TextIn(folder_ / folder / "preview.json"), &figures)
                    .ok());
    return figures;
  }

  fs::path folder_ = test::FreshFolder();
  int count_ = 0;
};

TEST_F(PreviewCommand, OfManyPointsShowsADraftFirst) {
  const std::string folder = (folder_ / "d").string();
  const Tokens words = {"preview", kSample, "--spacing", "0.1", "--out", folder};
  const Ended people = Type(words);
  EXPECT_THAT(people.output, HasSubstr("d/preview.html: DRAFT of "));
  EXPECT_EQ(Figures("d").draft_count(), 0u) << "the preview takes its place";
  EXPECT_THAT(TextIn(folder_ / "d/preview.html"), Not(HasSubstr("DRAFT")));
  Tokens program = words;
  program.push_back("--json");
  EXPECT_THAT(Type(program).output, Not(HasSubstr("DRAFT")));
}

TEST_F(PreviewCommand, OfAJobFileShowsWhatRunMakes) {
  const Ended preview = Type(
      {"preview", kSample, "--method", "sections", "--out", (folder_ / "p").string()});
  EXPECT_EQ(preview.exit_code, 0) << preview.output;
  EXPECT_THAT(preview.output,
              AllOf(HasSubstr("time  "), HasSubstr("verdict     READY"),
                    HasSubstr("lamp warm-up"), HasSubstr("preview.html")));
  EXPECT_THAT(TextIn(folder_ / "p/preview.html"), HasSubstr("data:image/png;base64,"));
  const Ended run =
      Type({"run", kSample, "--method", "sections", "--lockstep", "--warm-up", "0",
            "--no-record", "--out", (folder_ / "out").string()});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  JobReport report;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(
                  TextIn(folder_ / "out/report.json"), &report)
                  .ok());
  EXPECT_EQ(Figures("p").point_count(), report.points().made());
  EXPECT_EQ(Figures("p").time().ticks(), report.engrave().estimate_ticks())
      << "small enough for the job's own order: the same plan";
  // The same job by its number in the database of the job service.
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out")) {
    if (entry.path().filename() != "jobs.db") continue;
    const Ended again = Type({"preview", "1", "--database", entry.path().string(),
                              "--out", (folder_ / "again").string()});
    EXPECT_EQ(again.exit_code, 0) << again.output;
    EXPECT_EQ(Figures("again").cloud_checksum(), Figures("p").cloud_checksum());
    return;
  }
  FAIL() << "the run has left no database";
}

TEST_F(PreviewCommand, OfModelsTakesTheOptionsOfAJob) {
  const Ended ended = Type({"preview", kKnot, kKnot, "--height", "20", "--block", "60",
                            "50", "30", "--spacing", "0.4", "--up", "-y", "--json",
                            "--out", (folder_ / "p").string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("\"UP_AXIS_MINUS_Y\""));
  const JobPreview figures = Figures("p");
  EXPECT_EQ(figures.models_size(), 2);
  // The size is that of its points, which end up to a spacing below and above.
  EXPECT_NEAR(figures.size_mm().z(), 20, 2 * 0.4);
}

TEST_F(PreviewCommand, OfAJobOfContoursShowsThemWithTheirTime) {
  fs::copy_file(INTAGLIO_SOURCE_DIR "/tests/data/boards/gap_is_tool.gbr",
                folder_ / "board.gbr");
  std::ofstream(folder_ / "board.textproto")
      << "machine_file: \"mill\" course { files: \"board.gbr\" make: "
         "COURSE_MAKE_OUTLINE tool_diameter_mm: 0.1 round_corners: true }";
  const Ended ended = Type({"preview", (folder_ / "board.textproto").string(), "--json",
                            "--out", (folder_ / "p").string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  const JobPreview figures = Figures("p");
  EXPECT_EQ(figures.verdict(), "ready");
  EXPECT_EQ(figures.course().contour_count(), 2u);
  // Two tracks of 10 mm, round at their ends, followed at half of the tool beside them.
  const double length_mm = 2 * (2 * 10 + 3.14159265 * (0.25 + 0.1));
  EXPECT_NEAR(figures.course().work_mm(), length_mm, 1e-3);
  EXPECT_NEAR(figures.course().work_s(), length_mm / 5, 1e-3);
  EXPECT_GT(figures.time().machining_time_s(), length_mm / 5);
  EXPECT_THAT(TextIn(folder_ / "p/preview.svg"), HasSubstr("<svg"));
}

TEST_F(PreviewCommand, AsksForTheUnitBeforeAnythingIsMade) {
  const Ended ended = Type({"preview", kKnot, "--unit", "10000", "--block", "50", "50",
                            "50", "--out", (folder_ / "p").string()});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, AllOf(HasSubstr("larger than the block of 50 x 50 x 50 mm"),
                                  HasSubstr("--unit"), HasSubstr("--size")));
  EXPECT_FALSE(fs::exists(folder_ / "p"));
}

TEST_F(PreviewCommand, RunRefusesThisSizeBeforeItsProcessesStart) {
  const Ended ended = Type({"run", "--mesh", kKnot, "--unit", "10000", "--block", "50",
                            "50", "50", "--lockstep", "--out", (folder_ / "o").string()});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, HasSubstr("larger than the block of 50 x 50 x 50 mm"));
  EXPECT_FALSE(fs::exists(folder_ / "o"));
}

TEST_F(PreviewCommand, AJobFileAndAModelAreNotMixed) {
  const Ended ended = Type({"preview", kSample, kKnot});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, HasSubstr("one job file, or models"));
}

}  // namespace
}  // namespace intaglio
