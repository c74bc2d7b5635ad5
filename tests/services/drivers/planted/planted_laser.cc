#include <algorithm>
#include <array>
#include <utility>

#include "tests/services/drivers/planted/laser_wrapper.h"
#include "tests/services/drivers/planted/planted_faults.h"

namespace intaglio::drivers {
namespace {

struct FiresWithoutArm : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
    if (!up() || status().shutters_open == 0 || status().tick < next_tick_) return;
    next_tick_ = status().tick + 10;
    (void)inner_->Arm(
        {status().tick + 8, false, {true}, false, identity().max_energy_mj});
  }
  std::uint64_t next_tick_ = 0;
};
struct DropsAWindow : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    const bool fires =
        std::find(window.fire.begin(), window.fire.end(), true) != window.fire.end();
    return fires && inner_->up() ? Status{} : inner_->Arm(window);
  }
};
struct DoublesAWindow : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow again = window;
    again.first_tick += window.fire.size();
    auto armed = inner_->Arm(window);
    if (armed) (void)inner_->Arm(again);
    return armed;
  }
};
struct ArmsATickLate : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow late = window;
    ++late.first_tick;
    return inner_->Arm(late);
  }
};
struct ArmsOneMore : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow more = window;
    more.fire.push_back(true);
    return inner_->Arm(more);
  }
};
struct MovesLateWindows : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow moved = window;
    moved.first_tick = std::max(moved.first_tick, status().tick + 8);
    return inner_->Arm(moved);
  }
};
struct IgnoresTheGate : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    return inner_->Arm(
        {window.first_tick, false, window.fire, false, window.pulse_energy_mj});
  }
};
struct IgnoresTheEnergy : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow full = window;
    full.pulse_energy_mj = identity().max_energy_mj;
    return inner_->Arm(full);
  }
};
struct ForgetsDisarm : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Disarm() override { return {}; }
};
struct BelievesItsDisarm : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  bool disarmed() const override { return true; }
};
struct ForgetsStop : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status Stop() override { return {}; }
};
struct KeepsTheShutterOpen : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  Status OpenShutters(std::uint8_t mask) override {
    return mask == 0 ? Status{} : inner_->OpenShutters(mask);
  }
};
struct LosesReports : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(
        [&](link::PulseReport report) {
          report.outcome.pop_back();
          if (!report.outcome.empty()) sink(report);
        },
        past);
  }
};
struct DoublesReports : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(
        [&](const link::PulseReport& report) {
          sink(report);
          sink(report);
        },
        past);
  }
};
struct RemembersNothing : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, [&](link::PastReport report) {
      for (auto& outcome : report.outcome) outcome = link::TickOutcome::kNotArmed;
      past(report);
    });
  }
};
struct StaysUp : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  bool up() const override { return up_ = up_ || inner_->up(); }
  mutable bool up_ = false;
};
struct HasOneSession : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  std::uint64_t session() const override { return 1; }
};
struct OpensAgainByItself : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
    if (inner_->session() == session_ || !inner_->up()) return;
    const bool first = std::exchange(session_, inner_->session()) == 0;
    if (first) return;
    (void)inner_->Reset();
    (void)inner_->OpenShutters(1);
  }
  std::uint64_t session_ = 0;
};

struct ReportsAnotherStatus : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
    status_ = inner_->status();
    Spoil(status_);
  }
  const link::LaserStatus& status() const override { return status_; }
  virtual void Spoil(link::LaserStatus& status) = 0;

 private:
  link::LaserStatus status_ = {};
};
struct CountsOneMore : ReportsAnotherStatus {
  using ReportsAnotherStatus::ReportsAnotherStatus;
  void Spoil(link::LaserStatus& status) override { ++status.pulse_count; }
};
struct SwallowsInterlocks : ReportsAnotherStatus {
  using ReportsAnotherStatus::ReportsAnotherStatus;
  void Spoil(link::LaserStatus& status) override {
    status.interlocks |= link::kKeyOn | link::kDoorClosed | link::kStopReleased;
  }
};
struct CountsNoOpenings : ReportsAnotherStatus {
  using ReportsAnotherStatus::ReportsAnotherStatus;
  void Spoil(link::LaserStatus& status) override { status.openings = 0; }
};
struct KeepsTheFirstIdentity : LaserWrapper {
  using LaserWrapper::LaserWrapper;
  const link::LaserIdentity& identity() const override {
    if (first_.power_up == 0 && inner_->up()) first_ = inner_->identity();
    return first_;
  }
  mutable link::LaserIdentity first_ = {};
};

template <typename Fault>
std::unique_ptr<LaserController> PlantLaser(std::unique_ptr<LaserController> good) {
  return std::make_unique<Fault>(std::move(good));
}

constexpr char kArmed[] = "L1L2L4L5_armed", kDisarm[] = "L3_disarm", kCut[] = "L7L8_cut",
               kInterlocks[] = "L9_interlocks";

constexpr std::array kLaserFaults = {
    LaserFault{"FiresWithoutArm", kArmed, PlantLaser<FiresWithoutArm>},
    LaserFault{"DropsAWindow", kArmed, PlantLaser<DropsAWindow>},
    LaserFault{"DoublesAWindow", kArmed, PlantLaser<DoublesAWindow>},
    LaserFault{"ArmsATickLate", kArmed, PlantLaser<ArmsATickLate>},
    LaserFault{"ArmsOneMore", kArmed, PlantLaser<ArmsOneMore>},
    LaserFault{"MovesLateWindows", "L2L4_armed_again", PlantLaser<MovesLateWindows>},
    LaserFault{"IgnoresTheGate", "L2_gate", PlantLaser<IgnoresTheGate>},
    LaserFault{"IgnoresTheEnergy", "L13_energy", PlantLaser<IgnoresTheEnergy>},
    LaserFault{"ForgetsDisarm", kDisarm, PlantLaser<ForgetsDisarm>},
    LaserFault{"BelievesItsDisarm", kDisarm, PlantLaser<BelievesItsDisarm>},
    LaserFault{"ForgetsStop", "L3_stop", PlantLaser<ForgetsStop>},
    LaserFault{"KeepsTheShutterOpen", "L10_lamp_and_shutter",
               PlantLaser<KeepsTheShutterOpen>},
    LaserFault{"LosesReports", kArmed, PlantLaser<LosesReports>},
    LaserFault{"DoublesReports", kArmed, PlantLaser<DoublesReports>},
    LaserFault{"RemembersNothing", kArmed, PlantLaser<RemembersNothing>},
    LaserFault{"StaysUp", kCut, PlantLaser<StaysUp>},
    LaserFault{"HasOneSession", kCut, PlantLaser<HasOneSession>},
    LaserFault{"OpensAgainByItself", kCut, PlantLaser<OpensAgainByItself>},
    LaserFault{"CountsOneMore", kArmed, PlantLaser<CountsOneMore>},
    LaserFault{"SwallowsInterlocks", kInterlocks, PlantLaser<SwallowsInterlocks>},
    LaserFault{"CountsNoOpenings", kInterlocks, PlantLaser<CountsNoOpenings>},
    LaserFault{"KeepsTheFirstIdentity", "L11_power_cycle",
               PlantLaser<KeepsTheFirstIdentity>},
};

}  // namespace

std::span<const LaserFault> LaserFaults() { return kLaserFaults; }

}  // namespace intaglio::drivers
