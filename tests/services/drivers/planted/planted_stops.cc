#include "tests/services/drivers/planted/planted_stops.h"

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "tests/services/drivers/planted/laser_wrapper.h"
#include "tests/services/drivers/planted/motion_wrapper.h"

namespace intaglio::drivers {
namespace {

/// What a host compares is always that of the first status.
struct HidesStops : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  const link::LaserIdentity& identity() const override {
    if (!identity_ && inner_->up()) identity_ = inner_->identity();
    return identity_ ? *identity_ : inner_->identity();
  }
  const link::LaserStatus& status() const override {
    status_ = inner_->status();
    if (!openings_ && inner_->up()) openings_ = status_.openings;
    if (openings_) status_.openings = *openings_;
    return status_;
  }
  mutable std::optional<link::LaserIdentity> identity_;
  mutable std::optional<std::uint32_t> openings_;
  mutable link::LaserStatus status_;
};
struct CountsALostLine : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  const link::LaserStatus& status() const override {
    status_ = inner_->status();
    status_.openings += static_cast<std::uint32_t>(inner_->session());
    return status_;
  }
  mutable link::LaserStatus status_;
};
/// It leaves each safe state, and opens the shutters that its host has opened once.
struct OpensBehindEachStop : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
    if (mask_ == 0 || !inner_->up() || inner_->status().shutters_open == mask_) return;
    (void)inner_->Reset();
    (void)inner_->OpenShutters(mask_);
  }
  Status OpenShutters(std::uint8_t mask) override {
    mask_ = mask;
    return inner_->OpenShutters(mask);
  }
  std::uint8_t mask_ = 0;
};

/// A laser side that another object owns.
template <typename Fault>
struct OfAnother final : Fault {
  explicit OfAnother(LaserController& other)
      : Fault(std::unique_ptr<LaserController>(&other)) {}
  ~OfAnother() override { (void)this->inner_.release(); }
};

/// Its laser side, if it has one, has the fault, too.
template <typename Fault>
struct WithLaser : MotionWrapper {
  explicit WithLaser(std::unique_ptr<MotionDriver> inner)
      : MotionWrapper(std::move(inner)) {
    if (LaserController* const laser = inner_->laser()) laser_.emplace(*laser);
  }
  void Poll() override {
    inner_->Poll();
    state_ = inner_->state();
    Spoil(state_);
  }
  const DriverState& state() const override { return state_; }
  Status SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) override {
    return Begun(inner_->SetZero(here_mm, sets));
  }
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    return Begun(inner_->Jog(axes, speed_mm_s));
  }
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    return Begun(inner_->DrawOutline(corners_mm, speed_mm_s));
  }
  /// Whether the stage is at rest changes with the command, not with the next poll.
  Status Begun(Status begun) {
    state_.at_rest = inner_->state().at_rest;
    return begun;
  }
  LaserController* laser() override { return laser_ ? &*laser_ : nullptr; }
  virtual void Spoil(DriverState&) {}
  DriverState state_;
  std::optional<OfAnother<Fault>> laser_;
};

/// All is in order, and the run is the one of before.
struct HidesStopsOfMotion final : WithLaser<HidesStops> {
  using WithLaser::WithLaser;
  void Spoil(DriverState& state) override {
    if (!state.link_up) return;
    state.fault = intaglio_MOTION_OK;
    if (state.run == 0) state.run = run_;
    run_ = state.run;
  }
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    run_ = run;
    return inner_->BeginRun(run, tick, ns);
  }
  std::uint32_t run_ = 1;
};
struct TakesALostLineForAStop final : WithLaser<CountsALostLine> {
  using WithLaser::WithLaser;
  void Spoil(DriverState& state) override {
    was_up_ = was_up_ || state.link_up;
    lost_ = lost_ || (was_up_ && !state.link_up);
    if (lost_ && state.link_up) state.fault = intaglio_MOTION_FOLLOWING_ERROR;
  }
  bool was_up_ = false, lost_ = false;
};
/// It clears each fault, states a lost place by itself, and moves the stage 2 mm aside
/// when it is at rest again.
struct GoesOnBehindEachStop final : WithLaser<LaserWrapper> {
  using WithLaser::WithLaser;
  void Spoil(DriverState& state) override {
    const std::uint32_t openings = laser_ ? laser_->status().openings : 0;
    const bool stopped = !state.link_up || state.fault != intaglio_MOTION_OK ||
                         openings != openings_ || state.run < run_;
    openings_ = openings;
    if (run_ == 0) return;
    troubled_ = troubled_ || stopped;
    if (!troubled_ || !state.link_up || ++polls_ % 200 != 0) return;
    if (state.fault != intaglio_MOTION_OK) {
      (void)inner_->ClearFault();
      if (laser_) (void)laser_->Reset();
    } else if (!state.place_lost.empty()) {
      (void)inner_->SetZero(state.position_mm, {true, true, true});
    } else if (state.at_rest) {
      Move(state);
    }
  }
  void Move(const DriverState& state) {
    constexpr std::uint32_t kTicks = 100;
    motion::Segment aside;
    aside.end_position_mm = state.position_mm + Vec3(2, 0, 0);
    aside.duration_subticks = kTicks * motion::kSubticksPerTick;
    aside.program_end = true;
    if (inner_->BeginRun(++run_, state.tick + kTicks, 0))
      (void)inner_->Append(std::array{aside}, {});
  }
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    run_ = run;
    return inner_->BeginRun(run, tick, ns);
  }
  std::uint32_t run_ = 0, openings_ = 0, polls_ = 0;
  bool troubled_ = false;
};

/// A jog that ends before its place is begun again, as if nothing had been.
struct JogsOnBehindEachStop final : WithLaser<LaserWrapper> {
  using WithLaser::WithLaser;
  void Spoil(DriverState& state) override {
    if (!to_ || !state.link_up || ++polls_ % 200 != 0) return;
    if ((state.position_mm - *to_).norm() < 0.1) return to_.reset();
    if (state.fault != intaglio_MOTION_OK) {
      (void)inner_->ClearFault();
      if (laser_) (void)laser_->Reset();
    } else if (!state.place_lost.empty()) {
      (void)inner_->SetZero(state.position_mm, {true, true, true});
    } else if (state.at_rest) {
      (void)WithLaser::Jog(*to_, speed_mm_s_);
    }
  }
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    to_ = axes;
    speed_mm_s_ = speed_mm_s;
    return WithLaser::Jog(axes, speed_mm_s);
  }
  std::optional<Vec3> to_;
  double speed_mm_s_ = 0;
  std::uint32_t polls_ = 0;
};

template <typename Fault>
std::unique_ptr<LaserController> PlantStopOfLaser(std::unique_ptr<LaserController> good) {
  return std::make_unique<Fault>(std::move(good));
}
template <typename Fault>
std::unique_ptr<MotionDriver> PlantStopOfMotion(std::unique_ptr<MotionDriver> good) {
  return std::make_unique<Fault>(std::move(good));
}

constexpr std::array kLaserStopFaults = {
    LaserStopFault{"HidesStops", StopRows::kStops, PlantStopOfLaser<HidesStops>},
    LaserStopFault{"CountsALostLine", StopRows::kLine, PlantStopOfLaser<CountsALostLine>},
    LaserStopFault{"OpensBehindEachStop", StopRows::kAll,
                   PlantStopOfLaser<OpensBehindEachStop>},
};
constexpr std::array kMotionStopFaults = {
    MotionStopFault{"HidesStops", StopRows::kStops,
                    PlantStopOfMotion<HidesStopsOfMotion>},
    MotionStopFault{"TakesALostLineForAStop", StopRows::kLine,
                    PlantStopOfMotion<TakesALostLineForAStop>},
    MotionStopFault{"GoesOnBehindEachStop", StopRows::kAll,
                    PlantStopOfMotion<GoesOnBehindEachStop>},
    MotionStopFault{"HidesStopsOfAJog", StopRows::kStops,
                    PlantStopOfMotion<HidesStopsOfMotion>, true},
    MotionStopFault{"JogsOnBehindEachStop", StopRows::kAll,
                    PlantStopOfMotion<JogsOnBehindEachStop>, true},
};

}  // namespace

std::unique_ptr<MotionDriver> PlantNothing(std::unique_ptr<MotionDriver> good) {
  return std::make_unique<WithLaser<LaserWrapper>>(std::move(good));
}
std::unique_ptr<LaserController> PlantNothing(std::unique_ptr<LaserController> good) {
  return std::make_unique<LaserWrapper>(std::move(good));
}
std::span<const LaserStopFault> LaserStopFaults() { return kLaserStopFaults; }
std::span<const MotionStopFault> MotionStopFaults() { return kMotionStopFaults; }

}  // namespace intaglio::drivers
