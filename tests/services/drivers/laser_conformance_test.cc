#include "tests/services/drivers/laser_conformance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <tuple>

#include "services/drivers/motion_driver.h"

namespace intaglio::drivers {
namespace {

std::vector<std::string> Protocols() {
  std::vector<std::string> all;
  for (const LaserDriverKind& kind : LaserDriverKinds()) all.emplace_back(kind.protocol);
  for (const MotionDriverKind& kind : MotionDriverKinds())
    // In real time, by linuxcnc_driver_test: linuxcnc.
    if (kind.switches_laser && kind.protocol != "linuxcnc")
      all.emplace_back(kind.protocol);
  return all;
}

class EveryLaserDriver
    : public ::testing::TestWithParam<std::tuple<std::string, LaserCheck>> {};

TEST_P(EveryLaserDriver, Keeps) {
  const auto& [protocol, check] = GetParam();
  ASSERT_NE(MakeLaserRig(protocol), nullptr) << "laser_rig.cc has no rig for it";
  const LaserRigMaker make = [&protocol = protocol](const std::string& serial_number) {
    return MakeLaserRig(protocol, serial_number);
  };
  const std::string stated = MakeLaserRig(protocol)->stated_violation(check.name);
  const std::string found = ViolationOf(check, make);
  EXPECT_EQ(stated.empty() ? found : found.substr(0, stated.size()), stated) << found;
}

INSTANTIATE_TEST_SUITE_P(Of, EveryLaserDriver,
                         ::testing::Combine(::testing::ValuesIn(Protocols()),
                                            ::testing::ValuesIn(LaserChecks().begin(),
                                                                LaserChecks().end())),
                         [](const auto& param) {
                           std::string name = std::get<0>(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + "_" + std::get<1>(param.param).name;
                         });

/// A good driver with one fault.
class Planted : public LaserController {
 public:
  explicit Planted(std::unique_ptr<LaserController> inner) : inner_(std::move(inner)) {}
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
  }
  bool up() const override { return inner_->up(); }
  bool CanSend() const override { return inner_->CanSend(); }
  bool taken_over() const override { return inner_->taken_over(); }
  const std::string& message() const override { return inner_->message(); }
  const std::string& refusal() const override { return inner_->refusal(); }
  int fd() const override { return inner_->fd(); }
  const link::LaserIdentity& identity() const override { return inner_->identity(); }
  const link::LaserStatus& status() const override { return inner_->status(); }
  std::uint64_t status_number() const override { return inner_->status_number(); }
  std::chrono::nanoseconds status_at() const override { return inner_->status_at(); }
  std::uint64_t session() const override { return inner_->session(); }
  bool disarmed() const override { return inner_->disarmed(); }
  Status Lamp(bool on, double rate_hz) override { return inner_->Lamp(on, rate_hz); }
  Status OpenShutters(std::uint8_t mask) override { return inner_->OpenShutters(mask); }
  Status Arm(const link::ArmWindow& window) override { return inner_->Arm(window); }
  Status Disarm() override { return inner_->Disarm(); }
  Status Reset() override { return inner_->Reset(); }
  Status Stop() override { return inner_->Stop(); }
  Status RequestStatus() override { return inner_->RequestStatus(); }
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override {
    return inner_->RequestPast(first_tick, count);
  }

 protected:
  std::unique_ptr<LaserController> inner_;
};

struct ArmsATickLate : Planted {
  using Planted::Planted;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow late = window;
    ++late.first_tick;
    return inner_->Arm(late);
  }
};
struct ArmsOneMore : Planted {
  using Planted::Planted;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow more = window;
    more.fire.push_back(true);
    return inner_->Arm(more);
  }
};
struct MovesLateWindows : Planted {
  using Planted::Planted;
  Status Arm(const link::ArmWindow& window) override {
    link::ArmWindow moved = window;
    moved.first_tick = std::max(moved.first_tick, status().tick + 8);
    return inner_->Arm(moved);
  }
};
struct IgnoresTheGate : Planted {
  using Planted::Planted;
  Status Arm(const link::ArmWindow& window) override {
    return inner_->Arm({window.first_tick, false, window.fire});
  }
};
struct ForgetsDisarm : Planted {
  using Planted::Planted;
  Status Disarm() override { return {}; }
};
struct BelievesItsDisarm : Planted {
  using Planted::Planted;
  bool disarmed() const override { return true; }
};
struct ForgetsStop : Planted {
  using Planted::Planted;
  Status Stop() override { return {}; }
};
struct LosesReports : Planted {
  using Planted::Planted;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(
        [&](const link::PulseReport& report) {
          if (++reports_ % 3 != 0) sink(report);
        },
        past);
  }
  int reports_ = 0;
};
struct DoublesReports : Planted {
  using Planted::Planted;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(
        [&](const link::PulseReport& report) {
          sink(report);
          sink(report);
        },
        past);
  }
};
struct RemembersNothing : Planted {
  using Planted::Planted;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, [&](link::PastReport report) {
      for (auto& outcome : report.outcome) outcome = link::TickOutcome::kNotArmed;
      past(report);
    });
  }
};
struct StaysUp : Planted {
  using Planted::Planted;
  bool up() const override { return up_ = up_ || inner_->up(); }
  mutable bool up_ = false;
};
struct HasOneSession : Planted {
  using Planted::Planted;
  std::uint64_t session() const override { return 1; }
};
struct OpensAgainByItself : Planted {
  using Planted::Planted;
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
    if (inner_->session() == session_ || !inner_->up()) return;
    session_ = inner_->session();
    (void)inner_->Reset();
    (void)inner_->OpenShutters(1);
  }
  std::uint64_t session_ = 1;
};
struct ReportsAnotherStatus : Planted {
  using Planted::Planted;
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
struct HidesInterlocks : ReportsAnotherStatus {
  using ReportsAnotherStatus::ReportsAnotherStatus;
  void Spoil(link::LaserStatus& status) override {
    status.interlocks |= link::kKeyOn | link::kDoorClosed | link::kStopReleased;
  }
};
struct CountsNoOpenings : ReportsAnotherStatus {
  using ReportsAnotherStatus::ReportsAnotherStatus;
  void Spoil(link::LaserStatus& status) override { status.openings = 0; }
};
struct KeepsTheFirstIdentity : Planted {
  using Planted::Planted;
  const link::LaserIdentity& identity() const override {
    if (first_.power_up == 0 && inner_->up()) first_ = inner_->identity();
    return first_;
  }
  mutable link::LaserIdentity first_ = {};
};

using Plant =
    std::function<std::unique_ptr<LaserController>(std::unique_ptr<LaserController>)>;
template <typename Fault>
std::pair<std::string, Plant> Named(const char* name) {
  return {name, [](std::unique_ptr<LaserController> driver) {
            return std::make_unique<Fault>(std::move(driver));
          }};
}
#define PLANT(fault) Named<fault>(#fault)

class LaserConformance : public ::testing::TestWithParam<std::pair<std::string, Plant>> {
};

TEST_P(LaserConformance, Finds) {
  const LaserRigMaker make = [](const std::string& serial_number) {
    auto rig = MakeLaserRig("virtual-laser", serial_number);
    rig->driver = GetParam().second(std::move(rig->driver));
    return rig;
  };
  std::string found;
  for (const LaserCheck& check : LaserChecks()) {
    found = ViolationOf(check, make);
    if (!found.empty()) break;
  }
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(
    ThatADriver, LaserConformance,
    ::testing::Values(PLANT(ArmsATickLate), PLANT(ArmsOneMore), PLANT(MovesLateWindows),
                      PLANT(IgnoresTheGate), PLANT(ForgetsDisarm),
                      PLANT(BelievesItsDisarm), PLANT(ForgetsStop), PLANT(LosesReports),
                      PLANT(DoublesReports), PLANT(RemembersNothing), PLANT(StaysUp),
                      PLANT(HasOneSession), PLANT(OpensAgainByItself),
                      PLANT(CountsOneMore), PLANT(HidesInterlocks),
                      PLANT(CountsNoOpenings), PLANT(KeepsTheFirstIdentity)),
    [](const auto& plant) { return plant.param.first; });
#undef PLANT

}  // namespace
}  // namespace intaglio::drivers
