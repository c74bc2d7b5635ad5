// A feed hold at a grbl's panel in a jog of the driver of points: the controller is idle
// then, and nothing else says so. The tool's own way is the judge.

#include "services/drivers/grbl/grbl_jog.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/services/drivers/grbl/grbl_rig.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kSpeed_mm_s = 20;

/// A driver at its controller, at rest.
struct JogBench {
  explicit JogBench(const grbl::VirtualGrblOptions& options)
      : machine(options), driver(machine.MakeDriver("")) {
    EXPECT_TRUE(Until([this] { return driver->state().link_up; }));
    EXPECT_TRUE(Rests());
  }
  void StepFor(std::chrono::milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) {
      machine.Advance();
      driver->Poll();
    }
  }
  template <typename Condition>
  bool Until(const Condition& condition) {
    for (int i = 0; i < 5000 && !condition(); ++i) StepFor(1ms);
    return condition();
  }
  bool Rests() {
    return Until([this] { return driver->state().at_rest; });
  }
  double x() const { return machine.grbl.motion().Position_mm().x(); }

  GrblMachine machine;
  std::unique_ptr<GrblDriver> driver;
};

class GrblJog : public ::testing::TestWithParam<bool> {
 protected:
  grbl::VirtualGrblOptions options() const {
    return GetParam() ? grbl::GrblHal() : grbl::Grbl11();
  }
};

TEST_P(GrblJog, IsEndedByAHoldAtAnyInstant) {
  for (int wait_ms = 60; wait_ms < 160; ++wait_ms) {
    JogBench bench(options());
    ASSERT_TRUE(bench.driver->Jog({40, 0, 0}, kSpeed_mm_s));
    bench.StepFor(std::chrono::milliseconds(wait_ms));
    const double from_mm = bench.x();
    const std::uint32_t openings = bench.driver->status().openings;
    bench.machine.grbl.PressHold();
    bench.StepFor(500ms);
    ASSERT_FALSE(bench.machine.grbl.motion().moving()) << wait_ms;
    EXPECT_LT(bench.x() - from_mm, kSpeed_mm_s * GrblDriver::kAhead_s) << wait_ms;
    EXPECT_EQ(bench.driver->state().fault, intaglio_MOTION_SAFE_STATE) << wait_ms;
    EXPECT_THAT(bench.driver->state().message, HasSubstr("hold"));
    EXPECT_EQ(bench.driver->status().openings, openings + 1) << wait_ms;
    const double rests_mm = bench.x();
    bench.StepFor(1s);
    EXPECT_EQ(bench.x(), rests_mm) << wait_ms;
  }
}

// A host that turns seldom finds all that it sent executed: that is no hold.
TEST_P(GrblJog, GoesToItsPlaceForABusyHost) {
  JogBench bench(options());
  ASSERT_TRUE(bench.driver->Jog({20, -3, 1}, kSpeed_mm_s));
  for (int i = 0; i < 200 && !bench.driver->state().at_rest; ++i) {
    for (int ms = 0; ms < 40 + 17 * i % 160; ++ms) bench.machine.Advance();
    bench.driver->Poll();
  }
  EXPECT_TRUE(bench.driver->state().at_rest);
  EXPECT_EQ(bench.driver->state().fault, intaglio_MOTION_OK)
      << bench.driver->state().message;
  EXPECT_LT((bench.machine.grbl.motion().Position_mm() - Vec3(20, -3, 1)).norm(), 0.004);
}

INSTANTIATE_TEST_SUITE_P(Of, GrblJog, ::testing::Bool(), [](const auto& one) {
  return one.param ? "grblHAL" : "grbl11";
});

GrblStatus StatusAt(GrblState state, double x_mm) {
  GrblStatus status;
  status.state = state;
  status.work_mm = Vec3(x_mm, 0, 0);
  return status;
}

// Steps of 0.00625 mm are no multiples of the decimals that a move has.
TEST(GrblJogMoves, EndWhereTheyAreMeantTo) {
  GrblJogMoves moves;
  moves.Begin(Vec3(0.05, 0, 0), Vec3::Constant(160));
  double sum_mm = 0.05;
  for (int i = 1; i <= 1000; ++i) {
    const Vec3 to(0.05 + 0.0113 * i, 0, 0);
    const auto line = moves.Line(to, 1);
    ASSERT_TRUE(line && line->starts_with("$J=G91X"));
    sum_mm += std::stod(line->substr(7));
    moves.TakeSent(to);
  }
  EXPECT_NEAR(sum_mm, 0.05 + 11.3, 0.0032);
  EXPECT_EQ(moves.Line(Vec3(0.05 + 11.3, 0, 0), 1), std::nullopt);
}

TEST(GrblJogMoves, WaitForRestWhereAllThatWasQueuedHasGone) {
  GrblJogMoves moves;
  moves.Begin(Vec3::Zero(), Vec3::Constant(100));
  for (const double x_mm : {1.0, 2.0, 3.0}) moves.TakeSent(Vec3(x_mm, 0, 0));
  moves.TakeStatus(StatusAt(GrblState::kJog, 0.2), 3, 0);
  EXPECT_TRUE(moves.may_send());
  moves.TakeSent(Vec3(4, 0, 0));
  moves.TakeStatus(StatusAt(GrblState::kJog, 1.5), 1, 0);
  EXPECT_FALSE(moves.may_send()) << "the three of before have gone";
  moves.TakeStatus(StatusAt(GrblState::kIdle, 4), 0, 0);
  EXPECT_TRUE(moves.may_send() && !moves.was_cut()) << "they were executed";
  moves.TakeSent(Vec3(5, 0, 0));
  moves.TakeStatus(StatusAt(GrblState::kIdle, 4.5), 0, 0);
  EXPECT_TRUE(moves.was_cut() && !moves.may_send());
}

}  // namespace
}  // namespace intaglio::drivers
