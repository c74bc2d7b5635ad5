// The recipe "Started by hand" of docs/services.md: its commands as they are printed
// there, and what happens with an engraver that is more exact than the profile.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <regex>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

constexpr char kSource[] = INTAGLIO_SOURCE_DIR;

/// The code below that headline.
std::string RecipeIn(const std::string& document, const std::string& headline) {
  const auto at = document.find(headline);
  if (at == std::string::npos) return {};
  const auto begin = document.find("```\n", at) + 4;
  return document.substr(begin, document.find("```", begin) - begin);
}

class ByHand : public ::testing::Test {
 protected:
  ByHand() {
    fs::copy(fs::path(kSource) / "deploy", folder_ / "deploy",
             fs::copy_options::recursive);
    recipe_ = RecipeIn(testing::TextIn(fs::path(kSource) / "docs" / "services.md"),
                       "## Started by hand");
    // Other tests on this computer have the same recipe.
    recipe_ = std::regex_replace(recipe_, std::regex("--tag hand"), "--tag " + tag_);
  }
  ~ByHand() override {
    if (recipe_run_) kill(-recipe_run_->pid(), SIGKILL);
  }
  /// In the test's folder and in a process group of its own; afterwards its background
  /// processes are ended.
  Running& Start(const std::string& commands) {
    const fs::path bin = Program("intaglio").parent_path();
    std::ofstream(folder_ / "recipe.sh")
        << "cd '" << folder_.string() << "'\nexport PATH='" << bin.string()
        << "':$PATH\nexport INTAGLIO_MATERIALS_DB='" << folder_.string()
        << "/materials.db'\ntrap 'kill $(jobs -p); wait' EXIT\n"
        << commands;
    recipe_run_ = std::make_unique<Running>(
        "/usr/bin/setsid", std::vector<std::string>{"/bin/bash", folder_ / "recipe.sh"},
        folder_ / "output.txt");
    return *recipe_run_;
  }
  Ended Type(std::vector<std::string> words) {
    words.insert(words.end(), {"--tag", tag_});
    Running run(Program("intaglio"), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }

  fs::path folder_ = test::FreshFolder();
  std::string tag_ = "hand" + std::to_string(getpid());
  std::string recipe_;
  std::unique_ptr<Running> recipe_run_;
  int typed_ = 0;
};

TEST_F(ByHand, TheRecipeOfTheDocumentEngravesAtItsPlannedRate) {
  ASSERT_THAT(recipe_, HasSubstr("intaglio submit deploy/jobs/sample.textproto"));
  // Until the folder is complete; what is left is not made when the recipe has ended.
  Running& run = Start(recipe_ +
                       "\nstatus=$?\nfor i in $(seq 60); do test -e jobs/*/customer.png "
                       "&& break; sleep 1; done\nexit $status\n");
  // Half a minute of it is the lamp's warm-up.
  const Ended ended = run.WaitForEnd(200s);
  EXPECT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("job 1 done"));
  EXPECT_THAT(ended.output, ::testing::Not(HasSubstr("no progress")));
  EXPECT_THAT(ended.output, ::testing::Not(HasSubstr("tolerance")));
  const auto job = fs::directory_iterator(folder_ / "jobs")->path();
  EXPECT_TRUE(fs::is_regular_file(job / "views.png")) << ended.output;
  EXPECT_TRUE(fs::is_regular_file(job / "customer.png"));
  EXPECT_THAT(testing::TextIn(job / "report.json"), HasSubstr("\"evidence\": \"glass\""));
}

// At 200 Hz the job makes a point now and then, and nothing halts it for good.
TEST_F(ByHand, AnEngraverWithASmallerToleranceIsReportedAndTheCrawlRaisesAnAlarm) {
  const fs::path truth = folder_ / "deploy" / "truth" / "els-03.textproto";
  std::string text = testing::TextIn(truth);
  text = std::regex_replace(text, std::regex("position_tolerance_um: 30"),
                            "position_tolerance_um: 10");
  text = std::regex_replace(text, std::regex("warm_up_s: 30"), "warm_up_s: 0.5");
  std::ofstream(truth) << text;
  Running& run = Start(std::regex_replace(recipe_, std::regex(" --watch"),
                                          " --rate 200 --watch --events"));
  ASSERT_TRUE(Eventually(
      [&] {
        return Type({"status"}).output.find("position tolerance") != std::string::npos;
      },
      40s))
      << run.Output();
  const Ended mismatch = Type({"status"});
  EXPECT_EQ(mismatch.exit_code, 4);
  const std::string both =
      "the position tolerance of the stage controller is 10 um and that of the profile "
      "30 um";
  EXPECT_THAT(mismatch.output, HasSubstr("motion-bridge of els-03: " + both));
  Ended shown;
  ASSERT_TRUE(Eventually(
      [&] {
        shown = Type({"show", "1"});
        return shown.output.find("alarm      no progress") != std::string::npos;
      },
      150s))
      << shown.output << run.Output();
  EXPECT_THAT(shown.output, HasSubstr("outside its position tolerance"));
  EXPECT_THAT(shown.output, HasSubstr(both));
  EXPECT_THAT(Type({"list"}).output, HasSubstr("ALARM no progress"));
  EXPECT_THAT(Type({"status"}).output, HasSubstr("job 1: no progress"));
  EXPECT_TRUE(Eventually(
      [&] { return run.Output().find("\"alarm\":\"no progress") != std::string::npos; },
      20s))
      << run.Output();
  EXPECT_EQ(Type({"cancel", "1"}).exit_code, 0);
  EXPECT_EQ(run.WaitForEnd(30s).exit_code, 5) << run.Output();
}

}  // namespace
}  // namespace intaglio
