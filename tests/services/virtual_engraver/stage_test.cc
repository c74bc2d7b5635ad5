#include "services/virtual_engraver/stage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;

/// What the path commands `seconds` after its start, by the Hermite basis.
class CommandedPath {
 public:
  CommandedPath(std::vector<Knot> knots, double rate_hz)
      : knots_(std::move(knots)), rate_hz_(rate_hz) {}

  Vec3 At(double seconds) const {
    Vec3 p0 = Vec3::Zero(), v0 = Vec3::Zero();
    for (const Knot& knot : knots_) {
      const double duration = knot.subticks / (kTick * rate_hz_);
      const Vec3 p1 = knot.at_um / 1000, v1 = knot.speed_um_s / 1000;
      if (seconds < duration) {
        const double u = seconds / duration, u2 = u * u, u3 = u2 * u;
        return (2 * u3 - 3 * u2 + 1) * p0 + (3 * u2 - 2 * u3) * p1 +
               duration * ((u3 - 2 * u2 + u) * v0 + (u3 - u2) * v1);
      }
      seconds -= duration;
      p0 = p1;
      v0 = v1;
    }
    return p0;
  }

 private:
  std::vector<Knot> knots_;
  double rate_hz_;
};

/// tau x' = u(t) - x from x(0) = 0, classical fourth-order Runge-Kutta: with steps of
/// tau / 200 its error over the path is far below 1e-9 mm but at knots, where u'' jumps
/// inside a step; there it is of the order u'' step^3, below 1e-9 mm, too.
class LagByRungeKutta {
 public:
  LagByRungeKutta(CommandedPath path, double tau_s)
      : path_(std::move(path)), tau_s_(tau_s) {}

  const Vec3& AdvanceTo(double seconds) {
    const auto count = static_cast<int>(std::ceil((seconds - at_s_) / (tau_s_ / 200)));
    const double h = (seconds - at_s_) / count;
    for (int i = 0; i < count; ++i) {
      const double t = at_s_ + i * h;
      const Vec3 k1 = Slope(t, x_), k2 = Slope(t + h / 2, x_ + h / 2 * k1);
      const Vec3 k3 = Slope(t + h / 2, x_ + h / 2 * k2), k4 = Slope(t + h, x_ + h * k3);
      x_ += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    at_s_ = seconds;
    return x_;
  }

 private:
  Vec3 Slope(double t, const Vec3& x) const { return (path_.At(t) - x) / tau_s_; }
  CommandedPath path_;
  double tau_s_;
  double at_s_ = 0;
  Vec3 x_ = Vec3::Zero();
};

TEST(Stage, WithoutLagItIsWhereItIsCommanded) {
  Stage stage(Roomy(0));
  Begin(stage, kPath);
  const CommandedPath path(kPath, kRateHz);
  for (std::uint64_t tick = 1; tick < 20; ++tick) {
    stage.AdvanceTick(kRateHz);
    const double seconds =
        tick < kStartTick ? 0 : static_cast<double>(tick - kStartTick) / kRateHz;
    EXPECT_LT((stage.actual_mm() - path.At(seconds)).norm(), 1e-12) << tick;
  }
  EXPECT_FALSE(stage.running());
  EXPECT_EQ(stage.Report().fault, StageFault::kNone);
}

// Mirrors at 2 m/s and z at 50 mm/s: the mirrors rest after v^2 / 2a, 0.1 mm, and z after
// 0.5 mm; at the stage's own 1250 mm/s^2 the mirrors would be 1.6 m away.
TEST(Stage, MirrorsRestWithinTheirTravelLongBeforeZ) {
  for (const double border_mm : {100.0, 20.05}) {
    StageOptions options = Roomy(0);
    options.brake_acceleration_mm_s2 = 1250;
    options.mirror_brake_mm_s2 = 2e7;
    options.travel_max_mm.x() = border_mm;
    Stage stage(options);
    // From rest in one tick to 2 m/s at x = 10 mm, on for another of 10 mm.
    Begin(stage, {{{10'000, 0, 250}, {2'000'000, 0, 50'000}, kTick},
                  {{20'000, 0, 500}, {2'000'000, 0, 50'000}, kTick / 2},
                  {{20'000, 0, 600}, {0, 0, 0}, 100 * kTick}});
    while (stage.actual_mm().x() < 19.9) stage.AdvanceTick(20 * kRateHz);
    stage.Abort();
    const Vec3 at_mm = stage.actual_mm();
    Vec3 last_mm = at_mm;
    for (int i = 0; i < 4000 && stage.running(); ++i) {
      stage.AdvanceTick(20 * kRateHz);
      last_mm = stage.actual_mm();
      EXPECT_LE(last_mm.x(), std::min(at_mm.x() + 0.101, border_mm + 1e-9));
    }
    EXPECT_FALSE(stage.running());
    EXPECT_GT(last_mm.z(), at_mm.z() + 0.1) << "z needs longer";
  }
}

TEST(Stage, LagsAsTheDifferentialEquationStates) {
  // Lags far below, near and above the tick of 10 ms.
  for (const double tau_s : {0.0002, 0.003, 0.02}) {
    Stage stage(Roomy(tau_s));
    Begin(stage, kPath);
    LagByRungeKutta oracle(CommandedPath(kPath, kRateHz), tau_s);
    for (std::uint64_t tick = 1; tick < 25; ++tick) {
      stage.AdvanceTick(kRateHz);
      if (tick <= kStartTick) continue;
      const Vec3 expected =
          oracle.AdvanceTo(static_cast<double>(tick - kStartTick) / kRateHz);
      EXPECT_LT((stage.actual_mm() - expected).norm(), 2e-8) << tau_s << " " << tick;
    }
  }
}

TEST(Stage, AtConstantSpeedItIsSpeedTimesLagBehind) {
  Stage stage(Roomy(0.001));
  // 10 mm/s: 0.1 mm a tick, 0.01 mm behind.
  std::vector<Knot> line = {{{100, 0, 0}, {10000, 0, 0}, kTick}};
  for (int i = 2; i <= 20; ++i) line.push_back({{i * 100.0, 0, 0}, {10000, 0, 0}, kTick});
  Begin(stage, line);
  for (std::uint64_t tick = 0; tick < kStartTick + 15; ++tick) stage.AdvanceTick(kRateHz);
  EXPECT_NEAR(stage.actual_mm().x(), 1.5 - 0.01, 1e-9);
  (void)stage.Report();  // forgets the larger error of the start
  stage.AdvanceTick(kRateHz);
  const link::MotionStatus status = stage.Report();
  EXPECT_NEAR(status.following_error_max_nm, 10000, 1);
  EXPECT_EQ(status.vx_counts, 10000000);
}

TEST(Stage, InPositionOnlyWhereAPulseBelongsAndTheStageIs) {
  // Ends: on a tick with pulse, on a tick without, and between ticks with pulse, once
  // with another end at the same tick, once without.
  const std::vector<Knot> path = {
      {{50, 0, 0}, {10000, 0, 0}, kTick, false},
      {{150, 0, 0}, {10000, 0, 0}, kTick, true},
      {{250, 0, 0}, {10000, 0, 0}, kTick, false},
      {{300, 0, 0}, {10000, 0, 0}, kTick / 2, true},
      {{350, 0, 0}, {10000, 0, 0}, kTick / 2, true},
      {{400, 0, 0}, {10000, 0, 0}, kTick / 2, true},
      {{600, 0, 0}, {0, 0, 0}, 5 * kTick / 2, false, true},
  };
  // At 10 mm/s the stage is 10 mm/s * lag behind; the tolerance is 10 um.
  for (const double lag_s : {0.0, 0.0009, 0.0011}) {
    Stage stage(Roomy(lag_s));
    Begin(stage, path);
    std::vector<std::uint64_t> ticks;
    for (std::uint64_t tick = 1; tick < 10; ++tick) {
      stage.AdvanceTick(kRateHz);
      if (stage.in_position()) ticks.push_back(tick);
    }
    const std::vector<std::uint64_t> expected =
        lag_s < 0.001 ? std::vector<std::uint64_t>{kStartTick + 2, kStartTick + 4}
                      : std::vector<std::uint64_t>{};
    EXPECT_EQ(ticks, expected) << lag_s;
  }
}

// A controller that knows the drive of each axis expects it behind its command.
TEST(Stage, WithADriveForEachAxisItIsInPositionWhereTheDriveShouldBe) {
  const std::vector<Knot> path = {
      {{50, 0, 0}, {10000, 0, 0}, kTick, false},
      {{150, 0, 0}, {10000, 0, 0}, kTick, true},
      {{200, 0, 0}, {0, 0, 0}, kTick, false, true},
  };
  // 10 mm/s and 5 ms: 50 um behind, the tolerance is 10 um.
  StageOptions options = Roomy(0);
  MechanicsOptions slow;
  slow.lag_s = 0.005;
  options.mechanics.of_axis = {slow, slow, slow};
  for (const bool stuck : {false, true}) {
    Stage stage(options);
    Begin(stage, path);
    if (stuck) stage.Stick(0);
    for (std::uint64_t tick = 0; tick < kStartTick + 2; ++tick)
      stage.AdvanceTick(kRateHz);
    EXPECT_EQ(stage.in_position(), !stuck);
  }
}

// Axes in rad: what is compared with the tolerance, and reported, is the way of the
// focus.
TEST(Stage, OfAxesThatTurnTheErrorIsThatOfTheFocus) {
  const std::vector<Knot> path = {
      {{50, 0, 0}, {10000, 0, 0}, kTick, false},
      {{150, 0, 0}, {10000, 0, 0}, kTick, true},
      {{200, 0, 0}, {0, 0, 0}, kTick, false, true},
  };
  // At 10 units/s it is 10 units/s * lag behind, times 150 mm at the focus; tolerance
  // 10 um.
  for (const double lag_s : {0.0009 / 150, 0.0011 / 150}) {
    StageOptions options = Roomy(lag_s);
    options.focus_per_axis_unit_mm = Vec3(150, 1, 1);
    Stage stage(options);
    Begin(stage, path);
    for (std::uint64_t tick = 0; tick < kStartTick + 1; ++tick) {
      stage.AdvanceTick(kRateHz);
    }
    (void)stage.Report();  // forgets the larger error of the start
    stage.AdvanceTick(kRateHz);
    EXPECT_EQ(stage.in_position(), lag_s < 0.001 / 150);
    EXPECT_NEAR(stage.Report().following_error_max_nm, 10e6 * lag_s * 150, 1);
  }
}

TEST(Stage, LatchesOnePositionATickInFramesThatFit) {
  Stage stage(Roomy(0));
  Begin(stage, {{{15000, 0, 0}, {0, 0, 0}, 150 * kTick, false, true}});
  std::vector<Vec3> actual;
  for (int tick = 0; tick < 200; ++tick) {
    stage.AdvanceTick(kRateHz);
    actual.push_back(stage.actual_mm());
  }
  std::uint64_t next = kStartTick + 1;
  for (const link::Positions& frame : stage.TakePositions()) {
    EXPECT_EQ(frame.run, 1u);
    EXPECT_EQ(frame.first_tick, next);
    ASSERT_LE(frame.positions.size(), link::kMaxPositions);
    for (const auto& p : frame.positions) {
      EXPECT_NEAR(p.x_nm, actual[next - 1].x() * 1e6, 0.5001);
      ++next;
    }
  }
  EXPECT_EQ(next, kStartTick + 151);
  EXPECT_TRUE(stage.TakePositions().empty());
}

TEST(Stage, ReportsHowFarItsQueueReaches) {
  Stage stage(Roomy(0));
  const std::uint32_t free = stage.Report().queue_free;
  Begin(stage, kPath);
  std::uint64_t sum = 0;
  for (const Knot& knot : kPath) sum += knot.subticks;
  EXPECT_EQ(stage.Report().covered_through_tick, kStartTick + sum / kTick);
  EXPECT_EQ(stage.Report().queue_free, free - kPath.size());
  for (std::uint64_t tick = 0; tick < kStartTick + 3; ++tick) stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().covered_through_tick, kStartTick + sum / kTick);
  EXPECT_EQ(stage.Report().queue_free, free - kPath.size() + 1);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
