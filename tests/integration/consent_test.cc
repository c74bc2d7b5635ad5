// A cloud so dense that the glass may break: what a person is asked, and what happens
// with and without the answer. Through the real processes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>

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
using testing::RunJob;
using testing::Running;

// A knot of 2 mm, its points at two thirds of the closest spacing that is published for
// the lens.
const std::vector<std::string> kDense = {"--height", "2", "--spacing", "0.06"};

std::vector<std::string> Joined(std::vector<std::string> words,
                                const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class ConsentOfRun : public RunJob {};

TEST_F(ConsentOfRun, WithoutItNothingIsEngravedAndTheRemedyIsNamed) {
  const Ended run = Run(Joined({"--lockstep", "--warm-up", "0"}, kDense));
  ASSERT_TRUE(run.in_time);
  EXPECT_EQ(run.exit_code, 4) << run.output;
  EXPECT_THAT(run.output, HasSubstr("the glass may break at ("));
  EXPECT_THAT(run.output, HasSubstr("--accept breakage"));
  const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
  EXPECT_TRUE(!glass || glass->cracks.empty());
  EXPECT_TRUE(NothingLeft());
}

TEST_F(ConsentOfRun, WithItTheVerdictHasTheWarningAndTheReportThePerson) {
  const Ended run =
      Run(Joined({"--lockstep", "--warm-up", "0", "--accept", "breakage"}, kDense));
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("verdict     GOOD, WITH WARNINGS"));
  const JobReport report = Report();
  EXPECT_FALSE(report.verdict().good());
  EXPECT_EQ(report.verdict().kind(), "good_with_warnings");
  EXPECT_NE(report.breakage_accepted_by(), "");
  EXPECT_EQ(report.points().made(), report.points().planned());
  ASSERT_GT(report.warnings_size(), 0);
  EXPECT_EQ(report.warnings(report.warnings_size() - 1).code(), "breakage");
  Running verify(Program("intaglio"), {"verify", (folder_ / "out").string()},
                 folder_ / "verify.txt");
  const Ended verified = verify.WaitForEnd(testing::kBound);
  EXPECT_EQ(verified.exit_code, 0);
  EXPECT_THAT(verified.output, HasSubstr("GOOD, WITH WARNINGS"));
}

// A box without its lid: a ray along z crosses the bottom alone.
TEST_F(ConsentOfRun, RaysThatCrossAnOpenMeshOddlyNeedNoConsentAndAreNotGood) {
  std::ofstream(folder_ / "open.obj")
      << "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 4\nv 4 0 4\nv 4 4 4\nv 0 4 4\n"
         "f 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\n"
         "f 4 1 5\nf 4 5 8\n";
  Running run(Program("intaglio"),
              {"run",
               "--mesh",
               folder_ / "open.obj",
               "--method",
               "rays",
               "--vertex",
               "0.5",
               "--spacing",
               "0.3",
               "--block",
               "20",
               "20",
               "20",
               "--lockstep",
               "--warm-up",
               "0",
               "--out",
               folder_ / "out",
               "--materials",
               folder_ / "materials.db"},
              folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(testing::kBound);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("warning    "));
  EXPECT_THAT(ended.output, HasSubstr("verdict     GOOD, WITH WARNINGS"));
  EXPECT_THAT(Report().verdict().reasons(0), HasSubstr("an odd number of times"));
}

class ConsentOfAShop : public ::testing::Test {
 protected:
  ConsentOfAShop()
      : up_(Program("intaglio"),
            With({"up", "--folder", folder_ / "shop", "--materials",
                  folder_ / "materials.db", "--speed", "50", "--warm-up", "0", "--block",
                  "50", "50", "30"}),
            folder_ / "up.txt") {}
  ~ConsentOfAShop() override {
    up_.Signal(SIGINT);
    up_.WaitForEnd(15s);
  }
  static std::vector<std::string> With(std::vector<std::string> words) {
    return Joined(std::move(words),
                  {"--domain", "54", "--tag", "consent" + std::to_string(getpid())});
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words),
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  bool Shows(const std::string& text) {
    return Eventually(
        [&] {
          shown_ = Type({"show", "1"}).output;
          return shown_.find(text) != std::string::npos;
        },
        40s);
  }

  fs::path folder_ = test::FreshFolder();
  Running up_;
  int typed_ = 0;
  std::string shown_;
};

TEST_F(ConsentOfAShop, ItIsAskedForBeforeTheArmAndKept) {
  ASSERT_TRUE(Eventually([&] { return Type({"list"}).exit_code == 0; }, 20s));
  const Ended submitted = Type(Joined({"submit", testing::SampleJob().string()}, kDense));
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
  ASSERT_TRUE(Shows("waiting for arm")) << shown_;
  EXPECT_THAT(shown_, HasSubstr("\nbreakage   the glass may break at ("));
  EXPECT_THAT(shown_, HasSubstr("intaglio arm 1 --accept breakage"));
  const Ended refused = Type({"arm", "1"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.output, HasSubstr("the glass may break at ("));
  EXPECT_THAT(refused.output, HasSubstr("intaglio arm 1 --accept breakage"));
  const Ended armed = Type({"arm", "1", "--accept", "breakage"});
  EXPECT_EQ(armed.exit_code, 0) << armed.output;
  EXPECT_THAT(armed.output, HasSubstr("breakage   the glass may break at ("));
  ASSERT_TRUE(Shows("state      done")) << shown_;
  EXPECT_THAT(shown_, HasSubstr("\naccepted   breakage, by "));
  const std::string folder = (folder_ / "shop").string();
  const Ended watched = Type({"watch", "1"});
  EXPECT_EQ(watched.exit_code, 0);
  EXPECT_THAT(watched.output, HasSubstr("good_with_warnings"));
  EXPECT_THAT(watched.output, HasSubstr("breakage   the glass may break at ("));
  const std::string::size_type at = shown_.find("folder     ") + 11;
  const fs::path folder_of_job = shown_.substr(at, shown_.find('\n', at) - at);
  const std::string statistics = testing::TextIn(folder_of_job / "statistics.json");
  EXPECT_THAT(statistics, HasSubstr("\"good_with_warnings\""));
  EXPECT_THAT(statistics, HasSubstr("\"weight\": \"consent\""));
  Running json(Program("intaglio"), {"history", "--folder", folder, "--json"},
               folder_ / "history.txt");
  const std::string rows = json.WaitForEnd(20s).output;
  EXPECT_THAT(rows, HasSubstr("\"good_with_warnings\""));
  EXPECT_THAT(rows, HasSubstr("\"breakage\""));
  EXPECT_THAT(rows, Not(HasSubstr("\"breakage_accepted_by\": \"\"")));
}

}  // namespace
}  // namespace intaglio
