// Jobs through the product's processes and the reference controller, with laser and stage
// on one simulated board: the recorded edges of its outputs are the judge.
//
// ReferenceJob with INTAGLIO_LONG=1 alone, for its cases take minutes on a computer that
// others use: there the lamp is late now and then, which costs 150 ticks each time
// (docs/machines/els-03.md).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <regex>
#include <thread>

#include "tests/integration/course/flashes.h"
#include "tests/integration/point_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;

constexpr double kStepMm = 0.005;

/// The supplied board file with other values.
std::string BoardWith(const std::string& name,
                      const std::vector<std::pair<std::string, std::string>>& values) {
  std::string text = TextIn(INTAGLIO_SOURCE_DIR "/deploy/boards/" + name);
  for (const auto& [before, now] : values)
    text = std::regex_replace(text, std::regex(before), now);
  return text;
}

// A computer that others use is late at times: the triggers and the steps.
PointShop::Options OptionsOfShop() {
  PointShop::Options options;
  options.controller = "reference";
  options.profile = "els-03";
  options.program = "intaglio-reference-controller";
  options.files = {
      {"board.textproto",
       BoardWith("els-03.textproto",
                 {{"warm_up_s: 30", "warm_up_s: 0 trigger_max_delay_us: 10000"}})},
      {"stage.textproto",
       BoardWith("els-03-stage.textproto",
                 {{"max_step_rate_hz: 20000",
                   "max_step_rate_hz: 20000 following_error_limit_mm: 10"}})}};
  options.controller_options = {
      "--board",       "FOLDER/board.textproto", "--line",       "FOLDER/laser",
      "--stage-board", "FOLDER/stage.textproto", "--stage-line", "FOLDER/motion",
      "--simulate",    "FOLDER/record.txt",      "--panel",      "FOLDER/panel"};
  options.other_lines = {
      {"laser_line",
       "laser_line { protocol: \"virtual-laser\" device: \"FOLDER/laser\" }"},
      {"motion_line",
       "motion_line { protocol: \"virtual-stage\" device: \"FOLDER/motion\" }"},
      {"stage_lag_s", "stage_lag_s: 0"}};
  options.up_options = {"--lens", "f43"};
  options.job = KnotOf(4, 0.6) + "laser { rate_hz: 100 }\n";
  return options;
}

/// What the recorded edges come to.
struct Record {
  PointList pulses_mm;  ///< where the stage was, counted from its start
  std::size_t steps = 0, shutters_on = 0, enabled = 0;  ///< how often
};

Record ReadRecord(const std::filesystem::path& file) {
  Record record;
  std::array<std::int64_t, 3> steps = {};
  std::array<bool, 3> plus = {};
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(','), second = line.rfind(',');
    if (first == second) continue;
    const std::string output = line.substr(first + 1, second - first - 1);
    const bool on = line.back() == '1';
    if (output.ends_with(".direction"))
      plus.at(static_cast<std::size_t>(output[0] - 'x')) = on;
    if (!on) continue;
    if (output.ends_with(".step")) {
      const auto axis = static_cast<std::size_t>(output[0] - 'x');
      steps.at(axis) += plus.at(axis) ? 1 : -1;
      ++record.steps;
    }
    record.enabled += output == "enable";
    record.shutters_on += output.starts_with("shutters");
    if (output != "q_switch") continue;
    EXPECT_GT(record.enabled, 0U) << "a pulse before home";
    record.pulses_mm.emplace_back(kStepMm * static_cast<double>(steps[0]),
                                  kStepMm * static_cast<double>(steps[1]),
                                  kStepMm * static_cast<double>(steps[2]));
  }
  return record;
}

class ReferenceJob : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* const is_long = std::getenv("INTAGLIO_LONG");
    if (is_long == nullptr || std::string(is_long) != "1")
      GTEST_SKIP() << "INTAGLIO_LONG=1 runs it";
    shop = std::make_unique<PointShop>(OptionsOfShop());
    ASSERT_TRUE(shop->Open()) << shop->Log();
  }

  Record Edges() const { return ReadRecord(shop->record()); }

  /// By a person, who holds it; it is let go where the computer is too busy.
  void Home() {
    std::string homed;
    ASSERT_TRUE(Eventually(
        [&] {
          homed = shop->Type({"teach", "home"});
          return shop->Type({"teach", "status"}).find("not homed") == std::string::npos &&
                 homed.starts_with("x ");
        },
        90s))
        << homed << shop->Type({"teach", "status"});
  }
  void EngraveSome() {
    ASSERT_NO_FATAL_FAILURE(Home());
    ASSERT_TRUE(shop->Submit());
    // A busy computer's lamp may be late so often that it is paused.
    ASSERT_TRUE(Eventually(
        [&] {
          if (IsPaused()) shop->Type({"resume", "1"});
          return Edges().pulses_mm.size() >= 20;
        },
        240s))
        << shop->Type({"show", "1"});
  }
  bool IsPaused() const {
    return shop->Type({"show", "1"}).find("state      paused") != std::string::npos;
  }
  bool AwaitPaused() const {
    return Eventually([this] { return IsPaused(); }, 30s);
  }
  /// Nothing is stepped and nothing fires.
  void ExpectStill(const char* when) const {
    std::this_thread::sleep_for(500ms);
    const Record before = Edges();
    std::this_thread::sleep_for(3s);
    const Record after = Edges();
    EXPECT_EQ(after.pulses_mm.size(), before.pulses_mm.size()) << when;
    EXPECT_EQ(after.steps, before.steps) << when;
  }
  /// A person resumes it, until it is done; `more`: pulses of a controller before.
  void FinishAndJudge(const PointList& more = {}) {
    ASSERT_TRUE(shop->AwaitDone(240s, true)) << shop->shown() << shop->Log();
    const PointShop::Points job = shop->PointsOfJob();
    ASSERT_GT(job.at_mm.size(), 50U);
    PointList pulses = more;
    for (const Vec3& pulse : Edges().pulses_mm) pulses.push_back(pulse);
    const HeightFit fit = FitHeight(job.at_mm, pulses);
    std::vector<int> made(job.at_mm.size(), 0);
    double farthest_mm = 0;
    for (const Vec3& pulse : pulses) {
      const auto off_mm = [&](const Vec3& point) {
        return (fit.AxesAt(point) - pulse).norm();
      };
      const auto nearest = std::ranges::min_element(job.at_mm, {}, off_mm);
      farthest_mm = std::max(farthest_mm, off_mm(*nearest));
      ++made[static_cast<std::size_t>(nearest - job.at_mm.begin())];
    }
    const auto missing = static_cast<std::size_t>(std::ranges::count(made, 0));
    std::cout << "  " << job.at_mm.size() << " points, " << pulses.size()
              << " pulses, farthest " << 1000 * farthest_mm << " um, "
              << job.UncertainCount() << " uncertain\n";
    EXPECT_LE(std::ranges::max(made), 1);
    EXPECT_LE(missing, job.UncertainCount());
    // The tolerance of in-position, and home within a step of each axis.
    EXPECT_LE(farthest_mm, 0.03 + 2 * kStepMm);
  }

  std::unique_ptr<PointShop> shop;
};

TEST_F(ReferenceJob, MakesEveryPointOnceWhereItIsPlannedAndNoneBeforeItIsArmed) {
  ASSERT_NO_FATAL_FAILURE(Home());
  ASSERT_NE(shop->Type({"submit", shop->job().string()}).find("job 1"),
            std::string::npos);
  std::this_thread::sleep_for(5s);
  EXPECT_EQ(Edges().pulses_mm.size(), 0U);
  EXPECT_EQ(Edges().shutters_on, 0U);
  ASSERT_TRUE(Eventually(
      [&] {
        shop->Type({"arm", "1"});
        return Edges().pulses_mm.size() > 0;
      },
      60s))
      << shop->Type({"show", "1"});
  FinishAndJudge();
}

TEST_F(ReferenceJob, KilledControllerDoesNothingUntilAPersonHasHomedAndResumed) {
  ASSERT_NO_FATAL_FAILURE(EngraveSome());
  shop->KillController();
  const auto first = shop->folder() / "first.txt";
  std::filesystem::rename(shop->record(), first);
  EXPECT_TRUE(AwaitPaused()) << shop->Type({"show", "1"});
  shop->RestartController();
  ASSERT_TRUE(Eventually(
      [&] {
        return shop->Type({"teach", "status"}).find("not homed") != std::string::npos;
      },
      30s));
  ExpectStill("the controller is back");
  shop->Type({"resume", "1"});
  ExpectStill("the stage does not know where it is");
  EXPECT_EQ(Edges().steps + Edges().enabled + Edges().shutters_on, 0U);
  ASSERT_NO_FATAL_FAILURE(Home());
  ExpectStill("it is homed");
  EXPECT_EQ(Edges().pulses_mm.size(), 0U);
  FinishAndJudge(ReadRecord(first).pulses_mm);
}

TEST_F(ReferenceJob, AStopButtonThatIsReleasedStartsNothing) {
  ASSERT_NO_FATAL_FAILURE(EngraveSome());
  ASSERT_EQ(AskPanel(shop->folder(), "estop press"), "ok\n");
  EXPECT_TRUE(AwaitPaused()) << shop->Type({"show", "1"});
  ExpectStill("it is pressed");
  ASSERT_EQ(AskPanel(shop->folder(), "estop release"), "ok\n");
  ExpectStill("it is released");
  // The first word takes back what the laser keeps latched; the place is lost all the
  // same.
  shop->Type({"resume", "1"});
  ExpectStill("the stage does not know where it is");
  EXPECT_TRUE(AwaitPaused()) << shop->Type({"show", "1"});
  ASSERT_NO_FATAL_FAILURE(Home());
  ExpectStill("it is homed");
  FinishAndJudge();
}

// Nobody has homed it since its power-up. A shutter that opens until the stage has
// refused the run would be in the record for 10 ms.
TEST(ReferenceShop, OpensNoShutterBeforeAPersonHasHomedTheStage) {
  PointShop shop(OptionsOfShop());
  ASSERT_TRUE(shop.Open()) << shop.Log();
  ASSERT_TRUE(shop.Submit());
  const auto is_refused = [&] {
    const std::string shown = shop.Type({"show", "1"});
    return shown.find("state      paused") != std::string::npos &&
           shown.find("home it (intaglio teach home), then resume") != std::string::npos;
  };
  ASSERT_TRUE(Eventually(is_refused, 60s)) << shop.Type({"show", "1"});
  EXPECT_NE(shop.Type({"status"}).find("home it (intaglio teach home)"),
            std::string::npos);
  for (int resumed = 0; resumed < 2; ++resumed) {
    shop.Type({"resume", "1"});
    std::this_thread::sleep_for(1s);
    ASSERT_TRUE(Eventually(is_refused, 60s)) << shop.Type({"show", "1"});
  }
  const Record edges = ReadRecord(shop.record());
  EXPECT_EQ(edges.shutters_on, 0U);
  EXPECT_EQ(edges.steps + edges.enabled + edges.pulses_mm.size(), 0U);
}

TEST_F(ReferenceJob, ADoorThatIsClosedAgainStartsNothing) {
  ASSERT_NO_FATAL_FAILURE(EngraveSome());
  ASSERT_EQ(AskPanel(shop->folder(), "door open"), "ok\n");
  EXPECT_TRUE(AwaitPaused()) << shop->Type({"show", "1"});
  ExpectStill("it is open");
  ASSERT_EQ(AskPanel(shop->folder(), "door close"), "ok\n");
  ExpectStill("it is closed");
  FinishAndJudge();
}

}  // namespace
}  // namespace intaglio::testing
