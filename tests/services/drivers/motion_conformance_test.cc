#include "tests/services/drivers/motion_conformance.h"

#include <gtest/gtest.h>

#include <iostream>
#include <tuple>

namespace intaglio::drivers {
namespace {

std::vector<std::string> Protocols() {
  std::vector<std::string> all;
  // In real time, by linuxcnc_driver_test: linuxcnc.
  for (const MotionDriverKind& kind : MotionDriverKinds())
    if (kind.protocol != "linuxcnc") all.emplace_back(kind.protocol);
  return all;
}

class EveryMotionDriver
    : public ::testing::TestWithParam<std::tuple<std::string, MotionCheck>> {};

TEST_P(EveryMotionDriver, Keeps) {
  const auto& [protocol, check] = GetParam();
  ASSERT_NE(MakeMotionRig(protocol), nullptr) << "motion_rig.cc has no rig for it";
  const MotionRigMaker make = [&protocol = protocol](const std::string& serial_number) {
    return MakeMotionRig(protocol, serial_number);
  };
  EXPECT_EQ(ViolationOf(check, make), "");
}

INSTANTIATE_TEST_SUITE_P(Of, EveryMotionDriver,
                         ::testing::Combine(::testing::ValuesIn(Protocols()),
                                            ::testing::ValuesIn(MotionChecks().begin(),
                                                                MotionChecks().end())),
                         [](const auto& param) {
                           std::string name = std::get<0>(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + "_" + std::get<1>(param.param).name;
                         });

/// A good driver with one fault.
class Planted : public MotionDriver {
 public:
  explicit Planted(std::unique_ptr<MotionDriver> inner) : inner_(std::move(inner)) {}
  void Poll() override { inner_->Poll(); }
  int fd() const override { return inner_->fd(); }
  const DriverState& state() const override { return inner_->state(); }
  std::vector<LatchedPositions> TakePositions() override {
    return inner_->TakePositions();
  }
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    return inner_->BeginRun(run, tick, ns);
  }
  std::size_t Room() const override { return inner_->Room(); }
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    return inner_->Append(segments, end_ns);
  }
  Status AbortRun() override { return inner_->AbortRun(); }
  Status ClearFault() override { return inner_->ClearFault(); }

 protected:
  std::unique_ptr<MotionDriver> inner_;
};

struct BeginsATickLate : Planted {
  using Planted::Planted;
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    return inner_->BeginRun(run, tick + 1, ns);
  }
};
struct DropsASegment : Planted {
  using Planted::Planted;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    if (segments.size() < 3) return inner_->Append(segments, end_ns);
    std::vector<motion::Segment> fewer(segments.begin(), segments.end());
    fewer.erase(fewer.begin() + 1);
    return inner_->Append(fewer, end_ns);
  }
};
struct DoublesASegment : Planted {
  using Planted::Planted;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    if (segments.size() + 1 > Room()) return inner_->Append(segments, end_ns);
    std::vector<motion::Segment> more(segments.begin(), segments.end());
    more.insert(more.begin(), more.front());
    return inner_->Append(more, end_ns);
  }
};
struct SwapsAxes : Planted {
  using Planted::Planted;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    for (auto& part : all)
      for (Vec3& p : part.positions_mm) p = Vec3(p.y(), p.x(), p.z());
    return all;
  }
};
struct LosesPositions : Planted {
  using Planted::Planted;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    if (++calls_ % 40 == 0) all.clear();
    for (auto& part : all)
      if (part.positions_mm.size() > 1) part.positions_mm.pop_back();
    if (!all.empty() && calls_ % 7 == 0) all.pop_back();
    return all;
  }
  int calls_ = 0;
};
struct DoublesPositions : Planted {
  using Planted::Planted;
  std::vector<LatchedPositions> TakePositions() override {
    auto all = inner_->TakePositions();
    if (!all.empty()) all.push_back(all.back());
    return all;
  }
};
struct ForgetsAborts : Planted {
  using Planted::Planted;
  Status AbortRun() override { return {}; }
};
struct ClearsNoFault : Planted {
  using Planted::Planted;
  Status ClearFault() override { return {}; }
};
struct ReportsAnotherState : Planted {
  using Planted::Planted;
  void Poll() override {
    Planted::Poll();
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
struct HidesFaults : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override {
    if (state.link_up) state.fault = intaglio_MOTION_OK;
  }
};
struct StaysUp : ReportsAnotherState {
  using ReportsAnotherState::ReportsAnotherState;
  void Spoil(DriverState& state) override { state.link_up = up_ = up_ || state.link_up; }
  bool up_ = false;
};
struct PromisesRoom : Planted {
  using Planted::Planted;
  std::size_t Room() const override { return state().link_up ? 32 : 0; }
};
struct TakesAnyController : Planted {
  using Planted::Planted;
  Status BeginRun(std::uint32_t, std::uint64_t, std::uint64_t) override { return {}; }
};

using Plant = std::function<std::unique_ptr<MotionDriver>(std::unique_ptr<MotionDriver>)>;
template <typename Fault>
std::pair<std::string, Plant> Named(const char* name) {
  return {name, [](std::unique_ptr<MotionDriver> driver) {
            return std::make_unique<Fault>(std::move(driver));
          }};
}
#define PLANT(fault) Named<fault>(#fault)

class MotionConformance : public ::testing::TestWithParam<std::pair<std::string, Plant>> {
};

TEST_P(MotionConformance, Finds) {
  const MotionRigMaker make = [](const std::string& serial_number) {
    auto rig = MakeMotionRig("virtual-stage", serial_number);
    rig->driver = GetParam().second(std::move(rig->driver));
    return rig;
  };
  std::string found;
  for (const MotionCheck& check : MotionChecks()) {
    found = ViolationOf(check, make);
    if (!found.empty()) break;
  }
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(ThatADriver, MotionConformance,
                         ::testing::Values(PLANT(BeginsATickLate), PLANT(DropsASegment),
                                           PLANT(DoublesASegment), PLANT(SwapsAxes),
                                           PLANT(LosesPositions), PLANT(DoublesPositions),
                                           PLANT(ForgetsAborts), PLANT(ClearsNoFault),
                                           PLANT(MirrorsX), PLANT(HidesFaults),
                                           PLANT(StaysUp), PLANT(PromisesRoom),
                                           PLANT(TakesAnyController)),
                         [](const auto& plant) { return plant.param.first; });
#undef PLANT

}  // namespace
}  // namespace intaglio::drivers
