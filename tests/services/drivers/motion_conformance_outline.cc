// The oracle of an outline is the distance of the focus from the edges of its polygon,
// each millisecond in which the guide laser is on.

#include "tests/services/drivers/motion_conformance_outline.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "services/drivers/interface/laser_controller.h"
#include "tests/services/drivers/controller_fault.h"
#include "tests/services/drivers/motion_bench.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr double kGuideSpeedMmS = 400;
// A corner was reached; the focus goes 0.4 mm in a millisecond.
constexpr double kNearMm = 0.5;

using Corners = std::vector<Vec2>;

/// Beside where the focus is, and not symmetrical.
Corners CornersBeside(MotionBench& bench) {
  const Vec2 here = bench.rig().actual_mm().head<2>();
  return {here + Vec2(4, 3), here + Vec2(14, 5), here + Vec2(12, 13), here + Vec2(5, 9)};
}

bool DrawsOutlines(MotionBench& bench) {
  const auto drawn = bench.driver().DrawOutline(CornersBeside(bench), kGuideSpeedMmS);
  if (!drawn && drawn.error().code == ErrorCode::kUnsupported) {
    Expect(!drawn.error().message.empty(), "M19: the refusal is without a sentence");
    return false;
  }
  Expect(drawn, "DrawOutline");
  Expect(!bench.state().at_rest, "M19: it is at rest after DrawOutline");
  return true;
}

double BesideMm(const Corners& corners, const Vec2& at) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 from = corners[i], way = corners[(i + 1) % corners.size()] - from;
    const double share = std::clamp((at - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (from + share * way - at).norm());
  }
  return nearest;
}

/// Counts how often the guide laser comes to each corner.
class Watch {
 public:
  Watch(MotionBench& bench, Corners corners)
      : bench_(bench),
        corners_(std::move(corners)),
        is_near_(corners_.size(), false),
        visits(corners_.size(), 0) {}

  void Step() {
    bench_.Step();
    // A laser side that is told to open its shutter opens nothing.
    if (LaserController* const laser = bench_.driver().laser(); laser != nullptr)
      (void)laser->OpenShutters(1);
    Expect(!bench_.rig().may_fire(), "M19: the gate of the laser is open in an outline");
    const Vec2 at = bench_.rig().actual_mm().head<2>();
    if (bench_.rig().guide_is_on()) Take(at);
    was_on_ = bench_.rig().guide_is_on();
    before_ = at;
  }

 private:
  void Take(const Vec2& at) {
    const double tolerance_mm = std::numbers::sqrt2 * bench_.rig().tolerance_mm();
    Expect(BesideMm(corners_, at) <= tolerance_mm,
           fmt::format("M19: the guide laser is on {} mm beside the outline",
                       BesideMm(corners_, at)));
    Expect(!was_on_ || (at - before_).norm() <= 1.02e-3 * kGuideSpeedMmS,
           "M19: the outline is drawn faster than it may be");
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const bool is_near = (at - corners_[i]).norm() <= kNearMm;
      if (is_near && !is_near_[i]) ++visits[i];
      is_near_[i] = is_near;
    }
  }

  MotionBench& bench_;
  Corners corners_;
  std::vector<bool> is_near_;
  bool was_on_ = false;
  Vec2 before_ = Vec2::Zero();

 public:
  std::vector<int> visits;
};

void CloseShutter(MotionBench& bench) {
  if (LaserController* const laser = bench.driver().laser(); laser != nullptr)
    (void)laser->OpenShutters(0);
}

/// The courses of the bench are along x alone.
void ExpectGoodRunFromZero(MotionBench& bench, std::uint32_t run) {
  Expect(bench.driver().Jog(Vec3::Zero(), kGuideSpeedMmS), "Jog");
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M14: the jog does not end");
  bench.positions.clear();
  bench.ExpectGoodRun(run);
}

void AnOutlineIsDrawnUntilItIsHeld(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  const Corners corners = CornersBeside(bench);
  if (!DrawsOutlines(bench)) return;
  Watch watch(bench, corners);
  for (int ms = 0; ms < 2000; ++ms) watch.Step();
  for (const int count : watch.visits)
    Expect(count >= 3, fmt::format("M19: a corner was drawn {} times", count));
  Expect(!bench.state().at_rest, "M19: at rest in an outline");
  CloseShutter(bench);
  Expect(bench.driver().Hold(), "Hold");
  bench.StepFor(kReportTime);
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  Expect(bench.RestsWithin(100ms), "M15: the outline goes on");
  bench.ExpectStill(500ms, "M15: motion follows");
  Expect(bench.state().at_rest && bench.state().fault == intaglio_MOTION_OK,
         "M15: a hold is a fault");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on at rest");
  ExpectGoodRunFromZero(bench, 1);
}

void AnOutlineIsRefusedWhereAJogIs(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  const Corners good = CornersBeside(bench);
  if (!DrawsOutlines(bench)) return;
  const auto refuses = [&](const Corners& corners, double speed_mm_s = kGuideSpeedMmS) {
    return !bench.driver().DrawOutline(corners, speed_mm_s);
  };
  Expect(refuses(good) && !bench.driver().Jog(Vec3::Zero(), 1),
         "M14: an outline is not alone");
  Expect(bench.driver().Hold() && bench.Until([&] { return bench.state().at_rest; }),
         "M15: the outline goes on");
  const double end_mm = bench.rig().travel_max_mm().x();
  Expect(refuses({}) && refuses(Corners(kMaxOutlineCorners + 1, good.front())) &&
             refuses({good.front(), Vec2(end_mm + 0.01, 0)}) &&
             refuses({good.front(), Vec2(std::nan(""), 0)}) && refuses(good, 0) &&
             refuses(good, std::nan("")),
         "M19: an outline is taken that cannot be drawn");
  bench.ExpectStill(300ms, "M19: it moves for an outline that was refused");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on without an outline");
  ExpectGoodRunFromZero(bench, 1);
  bench.MoveALot(2);
  Expect(refuses(good), "M14: an outline in a run is taken");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on in a run");
  Expect(bench.driver().AbortRun(), "AbortRun");
  Expect(bench.Until([&] { return bench.state().at_rest && !bench.rig().moves(); }),
         "M5: the stage does not brake");
  bench.Begin(3);
  bench.Append({To(bench.x() + 0.25, kSpeed_mm_s, kRampTicks)});  // and no more
  bench.ExpectFault(intaglio_MOTION_STARVED, "M8: motion that ends in mid-run");
  Expect(bench.RestsWithin(kReportTime), "M6: the stage does not brake");
  Expect(refuses(good), "M14: an outline after a fault is taken");
  bench.ClearFault();
  bench.ExpectGoodRun(4);
}

void ARunInAnOutlineIsRefused(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  bench.StepFor(500ms);
  bench.Begin(1);
  bench.ExpectFault(intaglio_MOTION_LATE, "M15: a run that begins in an outline");
  Expect(bench.RestsWithin(kReportTime), "M15: the outline goes on");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  bench.ExpectStill(500ms, "M15: motion follows");
  Expect(bench.driver().Hold() && bench.Until([&] { return bench.state().at_rest; }),
         "M15: it does not rest");
  bench.ClearFault();
  ExpectGoodRunFromZero(bench, 2);
}

void AFaultEndsTheOutline(const MotionRigMaker& make, ControllerFault fault) {
  MotionBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  bench.StepFor(500ms);
  Expect(bench.rig().guide_is_on(), "M19: the guide laser is not on");
  if (!bench.rig().Inflict(fault)) return;
  Expect(bench.RestsWithin(kSilence + 100ms), "M9, M17: the outline goes on");
  bench.StepFor(kReportTime);
  Expect(fault == ControllerFault::kUnplug || !bench.rig().guide_is_on(),
         "M19: the guide laser is on behind the outline");
  bench.ExpectStill(1s, "M9, M17: motion follows");
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.state().link_up; }, 5s),
         "M10: the line does not come back: " + bench.Message());
  bench.ExpectStill(2s, "M10, M17: the outline goes on by itself");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  if (LaserController* const laser = bench.driver().laser(); laser != nullptr)
    Expect(laser->Reset(), "Reset");
  Expect(bench.driver().ClearFault(), "ClearFault");
  Expect(bench.Until([&] {
    return bench.state().fault == intaglio_MOTION_OK && bench.state().at_rest;
  }),
         "M17: the fault stays: " + bench.Message());
  // Where the mirrors rest may not be known before they are moved again.
  ExpectGoodRunFromZero(bench, 9);
}

}  // namespace

std::vector<MotionCheck> OutlineChecks() {
  std::vector<MotionCheck> all = {
      {"M19_outline", &AnOutlineIsDrawnUntilItIsHeld},
      {"M19_refusals", &AnOutlineIsRefusedWhereAJogIs},
      {"M19_run", &ARunInAnOutlineIsRefused},
  };
  for (const ControllerFault fault : kControllerFaults) {
    all.push_back(
        {fmt::format("M19_{}", NameOf(fault)),
         [fault](const MotionRigMaker& make) { AFaultEndsTheOutline(make, fault); }});
  }
  return all;
}

}  // namespace intaglio::drivers
