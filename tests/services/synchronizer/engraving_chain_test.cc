// Every link of the permission chain goes away in every phase of an engraving.

#include <gmock/gmock.h>

#include <string>
#include <tuple>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;
using Phase = Engraving::Phase;
constexpr std::uint32_t kChainPoints = 160;

struct Link {
  const char* name;
  void (*lose)(FakeCell&);
  void (*restore)(FakeCell&);
  /// The controller sees it before anybody else: nothing fires from that tick on.
  bool seen_by_controller;
  /// After it the permission has to be given anew: kRun when it broke off a run, kEver
  /// also between two runs.
  enum Latch { kNever, kRun, kEver } latches;
  /// Between two runs it is nothing: the next one begins by clearing it.
  bool only_in_a_run = false;
};

const Link kLinks[] = {
    {"PermissionStale", [](FakeCell& c) { c.permission_fresh = false; },
     [](FakeCell& c) { c.permission_fresh = true; }, false, Link::kNever},
    {"PermissionWithdrawn", [](FakeCell& c) { c.Withdraw(); },
     [](FakeCell& c) { c.Grant(); }, false, Link::kNever},
    {"StopOnTheBus", [](FakeCell& c) { c.stop_pressed = true; },
     [](FakeCell& c) { c.stop_pressed = false; }, false, Link::kEver},
    {"LaserLine", [](FakeCell& c) { c.CutLine(true); },
     [](FakeCell& c) { c.CutLine(false); }, false, Link::kRun},
    {"LaserMute", [](FakeCell& c) { c.laser.mute = true; },
     [](FakeCell& c) { c.laser.mute = false; }, false, Link::kRun},
    {"Key", [](FakeCell& c) { c.laser.key_on = false; },
     [](FakeCell& c) { c.laser.key_on = true; }, true, Link::kEver},
    {"Door", [](FakeCell& c) { c.laser.door_closed = false; },
     [](FakeCell& c) { c.laser.door_closed = true; }, true, Link::kEver},
    {"StopButton", [](FakeCell& c) { c.laser.PressStop(true); },
     [](FakeCell& c) { c.laser.PressStop(false); }, true, Link::kEver},
    {"SafeState", [](FakeCell& c) { c.laser.EnterSafeState(); }, [](FakeCell&) {}, true,
     Link::kRun, true},
    {"Lamp", [](FakeCell& c) { c.laser.lamp_dead = true; },
     [](FakeCell& c) { c.laser.lamp_dead = false; }, true, Link::kRun},
    {"Shutter", [](FakeCell& c) { c.laser.shutter_stuck = true; },
     [](FakeCell& c) { c.laser.shutter_stuck = false; }, true, Link::kRun},
    {"MotionSilent", [](FakeCell& c) { c.stage.silent = true; },
     [](FakeCell& c) { c.stage.silent = false; }, false, Link::kRun},
    {"MotionFault",
     [](FakeCell& c) { c.stage.Fail(intaglio_MOTION_FOLLOWING_ERROR, "it is stuck"); },
     [](FakeCell&) {}, true, Link::kRun, true},
};

struct Moment {
  const char* name;
  bool (*reach)(FakeCell&);
};

bool Begin(FakeCell& cell) {
  cell.Grant();
  return cell.StepUntil([&] { return cell.phase() == Phase::kRunning; });
}

bool Make(FakeCell& cell, std::uint64_t count) {
  cell.Grant();
  return cell.StepUntilMade(count);
}

const Moment kMoments[] = {
    {"Warming",
     [](FakeCell& c) {
       c.Grant();
       return c.StepUntil([&] { return c.laser.lamp_on(); }) &&
              c.phase() == Phase::kPreparing;
     }},
    {"Waiting",
     [](FakeCell& c) {
       c.Grant();
       const bool lit = c.StepUntil([&] { return c.laser.lamp_on(); });
       c.Withdraw();
       const bool waits = c.StepUntil([&] { return c.phase() == Phase::kWaiting; });
       c.Grant();
       return lit && waits;
     }},
    {"Beginning", [](FakeCell& c) { return Begin(c); }},
    {"LeadIn",
     [](FakeCell& c) {
       const bool began = Begin(c);
       c.StepFor(100ms);
       return began && c.laser.cracks().empty();
     }},
    {"Middle", [](FakeCell& c) { return Make(c, 40); }},
    {"Tail", [](FakeCell& c) { return Make(c, kChainPoints - 2); }},
    {"SecondPass",
     [](FakeCell& c) {
       if (!Make(c, 40)) return false;
       c.Withdraw();
       c.StepFor(500ms);
       return Make(c, 60);
     }},
    {"Halting",
     [](FakeCell& c) {
       if (!Make(c, 40)) return false;
       c.Withdraw();
       const bool halting = c.StepUntil([&] { return c.phase() == Phase::kHalting; });
       c.Grant();
       return halting;
     }},
};

class Chain : public testing::TestWithParam<std::tuple<Link, Moment, bool>> {
 protected:
  void SetUp() override {
    // What the synchronizer does without a renewal of the grant.
    cell_.acts_as_job_service = false;
    // No faster than a loss can be noticed.
    cell_.lockstep_ticks_a_step = 1;
    ASSERT_TRUE(moment_.reach(cell_));
  }

  /// What may still fire after the loss: the controller itself stops at once; the rest
  /// takes a turn and a frame; a silent line takes 250 ms, a silent stage its lease.
  std::chrono::nanoseconds LongestBeam() const {
    if (link_.seen_by_controller) return 0ms;
    const std::string name = link_.name;
    if (name == "LaserLine") return 260ms;
    if (name == "MotionSilent" || name == "LaserMute") return 510ms;
    return 5ms;
  }

  const Link link_ = std::get<0>(GetParam());
  const Moment moment_ = std::get<1>(GetParam());
  FakeCell cell_{{.points = kChainPoints, .lockstep = std::get<2>(GetParam())}};
};

INSTANTIATE_TEST_SUITE_P(Engraving, Chain,
                         testing::Combine(testing::ValuesIn(kLinks),
                                          testing::ValuesIn(kMoments), testing::Bool()),
                         [](const auto& tried) {
                           return std::string(std::get<0>(tried.param).name) +
                                  std::get<1>(tried.param).name +
                                  (std::get<2>(tried.param) ? "Lockstep" : "RealTime");
                         });

TEST_P(Chain, WithoutALinkNothingFiresAndEveryPointIsAccountedFor) {
  const bool running = cell_.phase() == Phase::kRunning;
  if (link_.only_in_a_run && !(running && cell_.stage.running()))
    GTEST_SKIP() << "does not apply: the next run begins by clearing it";
  const bool latches = link_.latches != Link::kNever && cell_.engraving->started() &&
                       (running || link_.latches == Link::kEver);
  link_.lose(cell_);
  const auto lost_at = cell_.now;
  // The longest is the time that a shutter has to open.
  cell_.StepFor(2600ms);
  if (cell_.done()) {  // it had nothing left to do before anybody could notice
    EXPECT_EQ(cell_.made(), kChainPoints);
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    return;
  }
  EXPECT_NE(cell_.phase(), Phase::kRunning);
  EXPECT_FALSE(cell_.engraving->message().empty());
  EXPECT_LE(cell_.laser.newest_pulse_at(), lost_at + LongestBeam());
  const auto armed_at = cell_.laser.newest_arm_at();
  cell_.StepFor(1500ms);
  EXPECT_EQ(cell_.laser.newest_arm_at(), armed_at);
  EXPECT_NE(cell_.phase(), Phase::kDone);
  // Without the line the controller closes them by itself, and what it fired is unknown.
  EXPECT_EQ(cell_.laser.shutters(), 0);
  if (cell_.controller->up() && !cell_.laser.mute) {
    EXPECT_EQ(cell_.Count(PointState::kArmed), 0);
  }
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());

  link_.restore(cell_);
  if (latches) {
    cell_.StepFor(1500ms);
    EXPECT_EQ(cell_.laser.newest_arm_at(), armed_at) << "it began again by itself";
    EXPECT_TRUE(cell_.engraving->faulted());
    EXPECT_TRUE(cell_.engraving->waits());
    EXPECT_EQ(cell_.Count(PointState::kArmed), 0);
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  }
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.made(), kChainPoints);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

}  // namespace
}  // namespace intaglio::synchronizer
