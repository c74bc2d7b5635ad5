#include "tests/services/drivers/marks/planted_marks.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace intaglio::drivers {
namespace {

/// It passes everything on: what a fault changes of a good driver is all that differs.
class MarkWrapper : public MarkDriver {
 public:
  explicit MarkWrapper(std::unique_ptr<MarkDriver> inner) : inner_(std::move(inner)) {}
  HandMotion* hand() override { return inner_->hand(); }
  void Poll() override {
    inner_->Poll();
    state_ = inner_->state();
    Change(state_);
  }
  int fd() const override { return inner_->fd(); }
  const MarkDeviceState& state() const override { return state_; }
  std::vector<MarkEvent> TakeEvents() override { return inner_->TakeEvents(); }
  Status Permit(bool permitted) override { return inner_->Permit(permitted); }
  Status Hold() override { return inner_->Hold(); }
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override {
    return inner_->Begin(run, pens);
  }
  std::size_t Room() const override { return inner_->Room(); }
  Status Append(const NumberedMark& mark) override { return inner_->Append(mark); }
  Status Finish() override { return inner_->Finish(); }
  Status Pause() override { return inner_->Pause(); }
  Status Stop() override { return inner_->Stop(); }
  Status Reset() override { return inner_->Reset(); }
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override {
    return inner_->RequestPast(run, first, count);
  }

 protected:
  virtual void Change(MarkDeviceState&) {}
  std::unique_ptr<MarkDriver> inner_;

 private:
  MarkDeviceState state_;
};

template <typename Faulty>
std::unique_ptr<MarkDriver> Plant(std::unique_ptr<MarkDriver> good) {
  return std::make_unique<Faulty>(std::move(good));
}

/// A constant power-up, and no stop of the controller's own.
struct HidesStops final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override {
    state.power_up = "1";
    state.openings = 0;
  }
};
struct HidesPowerUps final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override { state.power_up = "1"; }
};
/// It leaves each stop by itself, and goes on with a run of its own accord.
struct ResetsByItself final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override {
    if (!state.link_up || (state.fault.empty() && !state.safe_state)) return;
    (void)inner_->Reset();
    state.fault.clear();
    state.safe_state = false;
  }
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override {
    const Status begun = MarkWrapper::Begin(run, pens);
    return begun || state().link_up ? Status() : begun;
  }
};
struct CountsALostLine final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override {
    state.openings += static_cast<std::uint32_t>(state.session);
  }
};
struct ForgetsALostPlace final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override { state.place_lost.clear(); }
};
struct PermitsByItself final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Poll() override {
    (void)inner_->Permit(true);
    MarkWrapper::Poll();
  }
};
struct ReportsTwice final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  std::vector<MarkEvent> TakeEvents() override {
    auto events = inner_->TakeEvents();
    if (!events.empty()) events.push_back(events.back());
    return events;
  }
};
struct DoesNotStop final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Stop() override { return {}; }
};
struct DoesNotPause final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Pause() override { return {}; }
};
struct GoesOnInAHold final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Hold() override { return {}; }
};
struct BreaksInAHold final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Hold() override { return inner_->Stop(); }
};
struct KnowsNoPast final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status RequestPast(std::uint32_t, std::uint32_t, std::uint32_t) override { return {}; }
};
struct CountsNoDoor final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override { state.openings = 0; }
};
struct TakesMarksAlways final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Append(const NumberedMark& mark) override {
    (void)inner_->Append(mark);
    return {};
  }
};
struct AcceptsAnyController final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  void Change(MarkDeviceState& state) override {
    state.link_up = state.link_up || !state.refusal.empty();
    state.refusal.clear();
  }
};

/// A hand that passes outlines on.
class HandWrapper : public HandMotion {
 public:
  explicit HandWrapper(HandMotion& inner) : inner_(inner) {}
  const DriverState& state() const override { return inner_.state(); }
  Status ClearFault() override { return inner_.ClearFault(); }
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    return inner_.DrawOutline(corners_mm, speed_mm_s);
  }
  Status Hold() override { return inner_.Hold(); }

 protected:
  HandMotion& inner_;
};
template <typename FaultyHand>
class WithHand final : public MarkWrapper {
 public:
  explicit WithHand(std::unique_ptr<MarkDriver> inner)
      : MarkWrapper(std::move(inner)), hand_(*inner_->hand()) {}
  HandMotion* hand() override { return &hand_; }

 private:
  FaultyHand hand_;
};

struct DrawsElsewhere final : HandWrapper {
  using HandWrapper::HandWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    std::vector<Vec2> others(corners_mm.begin(), corners_mm.end());
    for (Vec2& corner : others) corner.x() += 0.05;
    return inner_.DrawOutline(others, speed_mm_s);
  }
};
struct DrawsACornerLess final : HandWrapper {
  using HandWrapper::HandWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    const bool has_more = corners_mm.size() > 1 && corners_mm.size() < 9;
    return inner_.DrawOutline(corners_mm.first(corners_mm.size() - has_more), speed_mm_s);
  }
};
struct DrawsTwiceAsFast final : HandWrapper {
  using HandWrapper::HandWrapper;
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    return inner_.DrawOutline(corners_mm, 2 * speed_mm_s);
  }
};
struct EndsNoOutline final : HandWrapper {
  using HandWrapper::HandWrapper;
  Status Hold() override { return {}; }
};
/// A run is taken in an outline, and is made behind it.
struct TakesARunInAnOutline final : MarkWrapper {
  using MarkWrapper::MarkWrapper;
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override {
    const Status begun = MarkWrapper::Begin(run, pens);
    return inner_->hand()->state().at_rest ? begun : Status();
  }
};

constexpr std::array kFaults = {
    MarkFault{"hides_stops", "K9K10_emergency_stop", &Plant<HidesStops>},
    MarkFault{"hides_power_ups", "K9K10_power_cycle", &Plant<HidesPowerUps>},
    MarkFault{"resets_by_itself", "K9K10_emergency_stop", &Plant<ResetsByItself>},
    MarkFault{"counts_a_lost_line", "K9K10_unplug", &Plant<CountsALostLine>,
              FaultOf::kKnownPowerUps},
    MarkFault{"forgets_a_lost_place", "K9K10_alarm", &Plant<ForgetsALostPlace>,
              FaultOf::kToolsWithAxes},
    MarkFault{"permits_by_itself", "K2_permission", &Plant<PermitsByItself>},
    MarkFault{"reports_twice", "K3_order", &Plant<ReportsTwice>},
    MarkFault{"does_not_stop", "K4_stop", &Plant<DoesNotStop>},
    MarkFault{"does_not_pause", "K5_pause", &Plant<DoesNotPause>},
    MarkFault{"goes_on_in_a_hold", "K11_hold", &Plant<GoesOnInAHold>},
    MarkFault{"breaks_in_a_hold", "K11_hold", &Plant<BreaksInAHold>},
    MarkFault{"knows_no_past", "K6_past", &Plant<KnowsNoPast>},
    MarkFault{"counts_no_door", "K7_door", &Plant<CountsNoDoor>},
    MarkFault{"takes_marks_always", "K1_refusals", &Plant<TakesMarksAlways>},
    MarkFault{"accepts_any_controller", "K8_another", &Plant<AcceptsAnyController>},
    MarkFault{"draws_elsewhere", "K12_outline", &Plant<WithHand<DrawsElsewhere>>,
              FaultOf::kGuideLasers},
    MarkFault{"draws_a_corner_less", "K12_outline", &Plant<WithHand<DrawsACornerLess>>,
              FaultOf::kGuideLasers},
    MarkFault{"draws_twice_as_fast", "K12_outline", &Plant<WithHand<DrawsTwiceAsFast>>,
              FaultOf::kGuideLasers},
    MarkFault{"ends_no_outline", "K12_outline", &Plant<WithHand<EndsNoOutline>>,
              FaultOf::kGuideLasers},
    MarkFault{"takes_a_run_in_an_outline", "K12_run", &Plant<TakesARunInAnOutline>,
              FaultOf::kGuideLasers},
};

}  // namespace

std::span<const MarkFault> MarkFaults() { return kFaults; }

}  // namespace intaglio::drivers
