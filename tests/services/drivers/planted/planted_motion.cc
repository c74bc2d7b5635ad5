#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "tests/services/drivers/planted/motion_wrapper.h"
#include "tests/services/drivers/planted/planted_faults.h"

namespace intaglio::drivers {
namespace {

struct BeginsATickLate : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    return inner_->BeginRun(run, tick + 1, ns);
  }
};
struct BeginsNothing : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status BeginRun(std::uint32_t, std::uint64_t, std::uint64_t) override { return {}; }
};
struct DropsAnAppend : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    return ++calls_ == 1 ? Status{} : inner_->Append(segments, end_ns);
  }
  int calls_ = 0;
};
struct DropsASegment : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    if (segments.size() < 3) return inner_->Append(segments, end_ns);
    std::vector<motion::Segment> fewer(segments.begin(), segments.end());
    fewer.erase(fewer.begin() + 1);
    return inner_->Append(fewer, end_ns);
  }
};
struct DoublesASegment : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    if (segments.size() + 1 > Room()) return inner_->Append(segments, end_ns);
    std::vector<motion::Segment> more(segments.begin(), segments.end());
    more.insert(more.begin(), more.front());
    return inner_->Append(more, end_ns);
  }
};
struct SwapsAxes : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    for (auto& part : all)
      for (Vec3& p : part.positions_mm) p = Vec3(p.y(), p.x(), p.z());
    return all;
  }
};
struct LosesPositions : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    if (!all.empty() && ++parts_ % 3 == 0) all.pop_back();
    return all;
  }
  int parts_ = 0;
};
struct DoublesPositions : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    if (!all.empty()) all.push_back(all.back());
    return all;
  }
};
struct ForgetsWhereTheBlockHasToBe : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status RequireBlockAt(const Vec2&) override { return {}; }
};
struct MovesTheBlockElsewhere : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status MoveBlock(const Vec2& place_mm, double speed_mm_s) override {
    return inner_->MoveBlock(-place_mm, speed_mm_s);
  }
};
struct IgnoresAbort : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status AbortRun() override { return {}; }
};
struct IgnoresHold : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status Hold() override { return {}; }
};
struct JogsTwiceAsFast : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    return inner_->Jog(axes, 2 * speed_mm_s);
  }
};
struct DrawsAnOutlineElsewhere : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    std::vector<Vec2> others(corners_mm.begin(), corners_mm.end());
    if (others.size() <= kMaxOutlineCorners)
      for (Vec2& corner : others) corner.x() += 0.01;
    return inner_->DrawOutline(others, speed_mm_s);
  }
};
struct DrawsACornerLess : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    const bool has_more =
        corners_mm.size() > 1 && corners_mm.size() <= kMaxOutlineCorners;
    return inner_->DrawOutline(corners_mm.first(corners_mm.size() - has_more),
                               speed_mm_s);
  }
};
struct DrawsTwiceAsFast : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    return inner_->DrawOutline(corners_mm, 2 * speed_mm_s);
  }
};
struct EndsNoOutline : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    auto drawn = inner_->DrawOutline(corners_mm, speed_mm_s);
    draws_ = drawn.has_value();
    return drawn;
  }
  Status Hold() override { return draws_ ? Status{} : inner_->Hold(); }
  bool draws_ = false;
};
struct ClearsNoFault : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  Status ClearFault() override { return {}; }
};
struct PromisesRoom : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  std::size_t Room() const override { return inner_->Room() + 1; }
};

struct ReportsAnotherState : MotionWrapper {
  using MotionWrapper::MotionWrapper;
  void Poll() override {
    MotionWrapper::Poll();
    state_ = inner_->state();
    Spoil(state_);
  }
  const DriverState& state() const override { return state_; }
  virtual void Spoil(DriverState& state) = 0;

 private:
  DriverState state_ = {};
};
struct MirrorsX : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override { state.position_mm.x() *= -1; }
};
struct ReportsAStalePosition : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override {
    if (state.link_up && !first_) first_ = state.position_mm;
    if (first_) state.position_mm = *first_;
  }
  std::optional<Vec3> first_;
};
struct ReportsRest : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override { state.at_rest = true; }
};
struct SwallowsFaults : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override {
    if (state.link_up) state.fault = intaglio_MOTION_OK;
  }
};
struct KeepsTheLinkUp : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override { state.link_up = up_ = up_ || state.link_up; }
  bool up_ = false;
};

template <typename Fault>
std::unique_ptr<MotionDriver> PlantMotion(std::unique_ptr<MotionDriver> good) {
  return std::make_unique<Fault>(std::move(good));
}

constexpr char kRuns[] = "M2M3M4M12_runs", kOutline[] = "M19_outline";

constexpr std::array kMotionFaults = {
    MotionFault{"BeginsATickLate", kRuns, PlantMotion<BeginsATickLate>},
    MotionFault{"BeginsNothing", "M13_another_controller", PlantMotion<BeginsNothing>},
    MotionFault{"DropsAnAppend", kRuns, PlantMotion<DropsAnAppend>},
    MotionFault{"DropsASegment", kRuns, PlantMotion<DropsASegment>},
    MotionFault{"DoublesASegment", kRuns, PlantMotion<DoublesASegment>},
    MotionFault{"SwapsAxes", kRuns, PlantMotion<SwapsAxes>},
    MotionFault{"LosesPositions", kRuns, PlantMotion<LosesPositions>},
    MotionFault{"DoublesPositions", kRuns, PlantMotion<DoublesPositions>},
    MotionFault{"IgnoresAbort", "M5_abort", PlantMotion<IgnoresAbort>},
    MotionFault{"IgnoresHold", "M15_hold", PlantMotion<IgnoresHold>, true},
    MotionFault{"JogsTwiceAsFast", "M14_jog", PlantMotion<JogsTwiceAsFast>, true},
    MotionFault{"DrawsAnOutlineElsewhere", kOutline, PlantMotion<DrawsAnOutlineElsewhere>,
                false, true},
    MotionFault{"DrawsACornerLess", kOutline, PlantMotion<DrawsACornerLess>, false, true},
    MotionFault{"DrawsTwiceAsFast", kOutline, PlantMotion<DrawsTwiceAsFast>, false, true},
    MotionFault{"EndsNoOutline", kOutline, PlantMotion<EndsNoOutline>, false, true},
    MotionFault{"ForgetsWhereTheBlockHasToBe", "M20_elsewhere",
                PlantMotion<ForgetsWhereTheBlockHasToBe>, false, false, true},
    MotionFault{"MovesTheBlockElsewhere", "M20_block",
                PlantMotion<MovesTheBlockElsewhere>, false, false, true},
    MotionFault{"ClearsNoFault", "M3_late", PlantMotion<ClearsNoFault>},
    MotionFault{"PromisesRoom", "M2M9M10_cut", PlantMotion<PromisesRoom>},
    MotionFault{"MirrorsX", kRuns, PlantMotion<MirrorsX>},
    MotionFault{"ReportsAStalePosition", kRuns, PlantMotion<ReportsAStalePosition>},
    MotionFault{"ReportsRest", kRuns, PlantMotion<ReportsRest>},
    MotionFault{"SwallowsFaults", "M3_late", PlantMotion<SwallowsFaults>},
    MotionFault{"KeepsTheLinkUp", "M2M9M10_cut", PlantMotion<KeepsTheLinkUp>},
};

}  // namespace

std::span<const MotionFault> MotionFaults() { return kMotionFaults; }

}  // namespace intaglio::drivers
