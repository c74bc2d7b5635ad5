// Jobs through the product's processes and a controller of the grbl family.
//
// INTAGLIO_GRBL_KILLS: how many kills, default 4. INTAGLIO_MESHES: a folder with
// bunny.obj (tests/data/README.md); with INTAGLIO_LONG=1 some 5000 points of it, else
// some hundreds.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>

#include "tests/integration/grbl_shop.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// A whole job, without a disturbance of ours.
GrblJudgement WholeJob(const GrblShop::Options& options, std::chrono::seconds bound) {
  GrblShop shop(options);
  EXPECT_TRUE(shop.Open()) << shop.Log();
  EXPECT_TRUE(shop.Submit());
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(shop.AwaitDone(bound, true)) << shop.shown();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  const GrblJudgement judgement = shop.Judge();
  EXPECT_GT(judgement.points, 200U);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.unknown, 0U);
  // A place is rounded to half a step, and the pulse begins within one.
  EXPECT_LE(judgement.farthest_mm, 1.5 * kGrblStepMm);
  EXPECT_EQ(judgement.lit_at_rest_us, 0);
  std::cout << "  " << judgement.points << " points, " << judgement.made << " made, "
            << judgement.uncertain << " uncertain, in " << took.count() << " s, farthest "
            << 1000 * judgement.farthest_mm << " um\n";
  return judgement;
}

/// In real time: a computer that is busy may leave the line silent for 250 ms, which is a
/// loss of it. Then the job is tried again; nothing is doubled or lit at rest in any try.
void ExpectEveryPointOnce(const GrblShop::Options& options, std::chrono::seconds bound) {
  GrblJudgement judgement;
  for (int i = 0; i < 3 && (i == 0 || judgement.uncertain > 0); ++i) {
    judgement = WholeJob(options, bound);
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(judgement.made, judgement.points);
  EXPECT_EQ(judgement.uncertain, 0U);
}

// A bunny 20 mm high has 5000 points.
constexpr double kBunny5000Spacing_mm = 0.4;

struct Controller {
  const char* name;
  bool hal, tcp;
};

class GrblJob : public ::testing::TestWithParam<Controller> {};

TEST_P(GrblJob, MakesEveryPointOnceWithinAStep) {
  GrblShop::Options options;
  options.hal = GetParam().hal;
  options.tcp = GetParam().tcp;
  ExpectEveryPointOnce(options, 180s);
}

INSTANTIATE_TEST_SUITE_P(By, GrblJob,
                         ::testing::Values(Controller{"grblHAL_serial", true, false},
                                           Controller{"grbl11_serial", false, false},
                                           Controller{"grblHAL_tcp", true, true}),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(GrblBunny, HasEveryPointOnceWithinAStep) {
  const char* meshes = std::getenv("INTAGLIO_MESHES");
  if (meshes == nullptr) GTEST_SKIP() << "INTAGLIO_MESHES names no folder";
  const bool all = std::getenv("INTAGLIO_LONG") != nullptr;
  GrblShop::Options options;
  options.job = GrblShop::Mesh(std::filesystem::path(meshes) / "bunny.obj", 20,
                               all ? kBunny5000Spacing_mm : 3.2 * kBunny5000Spacing_mm);
  ExpectEveryPointOnce(options, all ? 900s : 180s);
}

TEST(GrblCheck, ComparesTheProfileWithTheSettingsOfTheController) {
  GrblShop shop({});
  Running good(Program("intaglio"), {"machine", "check", shop.profile().string()},
               test::FreshFolder("grbl_check") / "good.txt");
  const Ended agrees = good.WaitForEnd(60s);
  EXPECT_EQ(agrees.exit_code, 0) << agrees.output;
  EXPECT_THAT(agrees.output, HasSubstr("motion_line: the device agrees"));
  EXPECT_THAT(agrees.output,
              HasSubstr("laser_line: not compared with the device: it is an output"));
  std::string text = TextIn(shop.profile());
  const std::string speed = "max_speed_mm_s: 50";
  text.replace(text.find(speed), speed.size(), "max_speed_mm_s: 500");
  std::ofstream(shop.profile()) << text;
  Running bad(Program("intaglio"),
              {"machine", "check", shop.profile().string(), "--json"},
              test::FreshFolder("grbl_check") / "bad.txt");
  const Ended differs = bad.WaitForEnd(60s);
  EXPECT_EQ(differs.exit_code, 2) << differs.output;
  EXPECT_THAT(differs.output, HasSubstr("\"x.max_speed_mm_s\""));
  EXPECT_THAT(differs.output, HasSubstr("$110=6000 mm/min"));
}

constexpr double kKnotSpacing_mm = 0.3;

/// A job of some 50 points a kill; 651 are 3.2 mm high.
GrblShop::Options JobFor(int kills) {
  GrblShop::Options options;
  options.job =
      KnotOf(std::clamp(3.2 * std::sqrt(kills / 13.0), 3.2, 22.0), kKnotSpacing_mm);
  return options;
}

// Each is of the bridge or of the synchronizer, by turns, somewhere in the next 30
// points.
TEST(GrblKills, LeaveFewUncertainPointsAndDoubleNone) {
  const char* asked = std::getenv("INTAGLIO_GRBL_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 4;
  GrblShop shop(JobFor(kills));
  ASSERT_TRUE(shop.Open()) << shop.Log();
  ASSERT_TRUE(shop.Submit());
  std::mt19937 random(7);
  int killed = 0;
  std::size_t uncertain = 0, largest = 0;
  bool done = false;
  for (int i = 0; i < kills && !done; ++i) {
    const std::size_t at = shop.Flashes() + 1 + random() % 30;
    while (!done && shop.Flashes() < at) {
      if (!Eventually([&] { return shop.Flashes() >= at; }, 5s))
        done = shop.AwaitDone(3s, true);
    }
    // What the kill before has left is settled once the job goes on.
    const std::size_t now_uncertain = shop.PointsOfJob().UncertainCount();
    largest = std::max(largest, now_uncertain - uncertain);
    uncertain = now_uncertain;
    if (!done)
      killed +=
          shop.Kill(i % 2 == 0 ? "intaglio-motion-bridge" : "intaglio-synchronizer");
  }
  ASSERT_TRUE(shop.AwaitDone(600s, true)) << shop.shown();
  const GrblJudgement judgement = shop.Judge();
  largest = std::max(largest, judgement.uncertain - uncertain);
  EXPECT_GE(killed, std::min(kills, 4));
  EXPECT_EQ(judgement.doubled, 0U);
  EXPECT_EQ(judgement.stray, 0U);
  EXPECT_EQ(judgement.unknown, 0U);
  // They are of a kill; a busy computer that is silent for 250 ms between two loses its
  // line once more, so the largest number of one interval is only printed.
  EXPECT_LE(judgement.uncertain, 16U * static_cast<unsigned>(killed));
  EXPECT_EQ(judgement.lit_at_rest_us, 0);
  EXPECT_LE(judgement.farthest_mm, 1.5 * kGrblStepMm);
  std::cout << "  " << killed << " kills, " << judgement.points << " points, "
            << judgement.made << " made, " << judgement.uncertain
            << " uncertain, at most " << largest << " of a kill\n";
}

}  // namespace
}  // namespace intaglio::testing
