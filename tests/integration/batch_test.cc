// Many jobs over two machines, driven by a script that knows nothing of DDS.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

Ended Type(const std::vector<std::string>& words, const fs::path& folder) {
  setenv("INTAGLIO_MATERIALS_DB", (folder / "materials.db").c_str(), 1);
  Running run(Program("intaglio"), words, folder / "output.txt");
  return run.WaitForEnd(60s);
}

// All jobs but the bad one are good, over both machines, in the table, the results and
// the history. INTAGLIO_BATCH_JOBS=50 takes as many as the example does by itself.
TEST(Batch, TheExampleMakesAllButTheBadOne) {
  const fs::path folder = test::FreshFolder();
  const char* all = std::getenv("INTAGLIO_BATCH_JOBS");
  const std::string count = all != nullptr ? all : "10";
  Running script(
      INTAGLIO_SOURCE_DIR "/deploy/examples/two_cells.py",
      {"--intaglio", Program("intaglio").string(), "--folder", folder.string(), "--count",
       count, "--domain", "46", "--tag", "batch" + std::to_string(getpid())},
      folder / "script.txt");
  const Ended ended = script.WaitForEnd(all != nullptr ? 600s : 110s);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output,
              HasSubstr(std::to_string(std::stoi(count) - 1) + " good, 1 failed"));
  EXPECT_THAT(ended.output, HasSubstr("empty.stl: it has no triangles"));
  const Ended history = Type(
      {"history", "--folder", (folder / "left").string(), "--verdict", "good"}, folder);
  EXPECT_EQ(history.exit_code, 0) << history.output;
  EXPECT_EQ(std::count(history.output.begin(), history.output.end(), '\n'),
            std::stoi(count) + 1)
      << "a header, all but one, and how right the estimates were\n"
      << history.output;
}

// Nothing is submitted when a line is wrong, and the error is reported without a shop.
TEST(Batch, EveryMistakeOfEveryLineIsReportedBefore) {
  const fs::path folder = test::FreshFolder();
  const std::string job = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto";
  std::ofstream(folder / "wrong.jsonl")
      << R"({"id":"a","job":")" << job
      << R"(","overrides":{"block.margin_mm":-1,"glass":"K"}})"
      << "\n"
      << R"({"id":"b","job":")" << job << R"(","overrides":{"blok":1},"after":["c"]})"
      << "\n"
      << R"({"id":"c","job":")" << job << R"(","cell":"nowhere","after":["b"]})"
      << "\n"
      << R"({"id":"d","job":"absent.textproto"})"
      << "\n";
  const Ended ended = Type({"batch", (folder / "wrong.jsonl").string()}, folder);
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output,
              HasSubstr("line 1 (a): block.margin_mm: -1 is outside 0..100"));
  EXPECT_THAT(ended.output, HasSubstr("line 2 (b): column 'blok'"));
  EXPECT_THAT(ended.output, HasSubstr("line 3 (c): cell: 'nowhere'"));
  EXPECT_THAT(ended.output, HasSubstr("in a cycle, b after c after b"));
  EXPECT_THAT(ended.output, HasSubstr("line 4 (d): "));
  EXPECT_THAT(ended.output, HasSubstr("absent.textproto"));

  std::ofstream(folder / "right.csv") << "id,block.margin_mm\na,2\nb,3.5\n";
  const Ended right =
      Type({"batch", (folder / "right.csv").string(), "--job", job, "--check"}, folder);
  EXPECT_EQ(right.exit_code, 0) << right.output;
  EXPECT_THAT(right.output, HasSubstr("2 jobs, all without mistakes"));
}

// What is engraved goes on, what waits is cancelled, what is left is never submitted; the
// state of each is reported.
TEST(Batch, CtrlCLeavesTheBlockInTheMachineAndCancelsTheRest) {
  const fs::path folder = test::FreshFolder();
  const std::vector<std::string> bus = {"--domain", "48", "--tag",
                                        "interrupt" + std::to_string(getpid())};
  const auto with = [&bus](std::vector<std::string> words) {
    words.insert(words.end(), bus.begin(), bus.end());
    return words;
  };
  setenv("INTAGLIO_MATERIALS_DB", (folder / "materials.db").c_str(), 1);
  Running up(Program("intaglio"),
             with({"up", "--folder", (folder / "shop").string(), "--speed", "6",
                   "--block", "50", "50", "30"}),
             folder / "up.txt");
  ASSERT_TRUE(testing::Eventually(
      [&] { return up.Output().find("the shop is open") != std::string::npos; }, 60s))
      << up.Output();
  std::ofstream(folder / "knots.csv") << "id,after,models[0].placement.fit_height_"
                                         "mm\nfirst,,16\nsecond,,6\nthird,first,6\n";
  Running batch(
      Program("intaglio"),
      with({"batch", (folder / "knots.csv").string(), "--job",
            INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--parallel", "2",
            "--arm", "--events", "--results", (folder / "results.json").string()}),
      folder / "batch.txt");
  ASSERT_TRUE(testing::Eventually(
      [&] { return batch.Output().find("\"state\":\"engraving\"") != std::string::npos; },
      60s))
      << batch.Output();
  batch.Signal(SIGINT);
  const Ended ended = batch.WaitForEnd(20s);
  EXPECT_EQ(ended.exit_code, 5) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("continues: intaglio watch 1"));
  EXPECT_THAT(ended.output, HasSubstr("\"event\":\"left\""));
  EXPECT_THAT(ended.output, HasSubstr("1 cancelled, 2 not made"));
  // A host that is too busy for the machine's lines may have paused it.
  const Ended show = Type(with({"show", "1"}), folder);
  EXPECT_THAT(show.output,
              ::testing::ContainsRegex("state      (engraving|paused|done)"));
  Type(with({"cancel", "1"}), folder);
}

// One arm a block: what a person takes back in the warm-up stays taken back.
TEST(Batch, APauseAndAStopInTheWarmUpAreLeftToAPerson) {
  const fs::path folder = test::FreshFolder();
  const std::vector<std::string> bus = {"--domain", "48", "--tag",
                                        "once" + std::to_string(getpid())};
  const auto with = [&bus](std::vector<std::string> words) {
    words.insert(words.end(), bus.begin(), bus.end());
    return words;
  };
  setenv("INTAGLIO_MATERIALS_DB", (folder / "materials.db").c_str(), 1);
  Running up(Program("intaglio"),
             with({"up", "--folder", (folder / "shop").string(), "--warm-up", "20",
                   "--block", "50", "50", "30"}),
             folder / "up.txt");
  ASSERT_TRUE(testing::Eventually(
      [&] { return up.Output().find("the shop is open") != std::string::npos; }, 60s))
      << up.Output();
  std::ofstream(folder / "knots.csv") << "id,models[0].placement.fit_height_mm\nonly,5\n";
  Running batch(
      Program("intaglio"),
      with({"batch", (folder / "knots.csv").string(), "--job",
            INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--arm", "--events"}),
      folder / "batch.txt");
  ASSERT_TRUE(testing::Eventually(
      [&] { return batch.Output().find("\"armed\":true") != std::string::npos; }, 60s))
      << batch.Output();
  const Ended paused = Type(with({"pause", "1"}), folder);
  EXPECT_EQ(paused.exit_code, 0) << paused.output;
  const auto is_armed = [&] {
    const std::string show = Type(with({"show", "1"}), folder).output;
    return show.find("armed\n") != std::string::npos ||
           show.find("state      engraving") != std::string::npos;
  };
  // Batches armed again after 5 s.
  EXPECT_FALSE(testing::Eventually(is_armed, 7s));
  EXPECT_EQ(Type(with({"stop", "els-03"}), folder).exit_code, 0);
  EXPECT_EQ(Type(with({"stop", "els-03", "--reset"}), folder).exit_code, 0);
  EXPECT_FALSE(testing::Eventually(is_armed, 7s));
  const Ended armed = Type(with({"arm", "1"}), folder);
  EXPECT_EQ(armed.exit_code, 0) << armed.output;
  const Ended ended = batch.WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("only (job 1, els-03) waits for a person: paused"));
  EXPECT_THAT(ended.output, HasSubstr("waits for a person: emergency stop"));
}

}  // namespace
}  // namespace intaglio
