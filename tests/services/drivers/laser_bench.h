#pragma once

// A laser rig in the middle of a check.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/rig_expect.h"

namespace intaglio::drivers {

using Ticks = std::vector<std::uint64_t>;

class LaserBench {
 public:
  explicit LaserBench(const LaserRigMaker& make, const std::string& serial_number = "")
      : rig_(make(serial_number)) {}

  LaserRig& rig() { return *rig_; }
  LaserController& driver() { return *rig_->driver; }
  std::uint64_t tick() { return rig_->tick(); }

  void StepFor(milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) Step();
  }
  /// A millisecond. A controller in lockstep waits for decided ticks: it gets idle ones,
  /// as from a synchronizer.
  void Step();
  bool Until(const std::function<bool()>& condition,
             milliseconds limit = std::chrono::seconds(3)) {
    for (std::int64_t i = 0; i < limit.count() && !condition(); ++i) Step();
    return condition();
  }
  void PassTicks(std::uint64_t count) {
    const std::uint64_t end = tick() + count;
    const auto passed = [&] {
      if (end > tick() + 64) DecideIdleUpTo(std::min(end - 32, tick() + 400));
      return tick() >= end;
    };
    Expect(Until(passed, milliseconds(1000 + 20 * count)),
           "the laser's ticks do not pass");
  }
  void Connect() {
    Expect(Until([this] { return driver().up(); }),
           "L8: the line does not come up: " + driver().message());
  }
  /// Warm and open, at the slow rate.
  void Prepare() {
    Expect(driver().Reset().has_value(), "Reset is refused");
    Expect(driver().Lamp(true, rig_->rate_hz()).has_value(), "Lamp is refused");
    Expect(driver().OpenShutters(1).has_value(), "OpenShutters is refused");
    Expect(Until([this] {
             return driver().Has(link::kLampWarm) && driver().status().shutters_open == 1;
           }),
           "L10: a warm lamp and an open shutter are not reported");
    Expect(rig_->shutters() == 1, "L10: the shutter is not open");
  }
  void ConnectAndPrepare() {
    Connect();
    Prepare();
  }
  /// From `ahead` ticks on; returns the ticks that are to fire.
  Ticks Arm(std::uint64_t ahead, const std::vector<bool>& fire, bool gated = false) {
    const std::uint64_t first = tick() + ahead;
    DecideIdleUpTo(first - 1);
    idle_through_ = 0;
    Expect(driver().Arm({first, gated, fire, false, energy_mj()}).has_value(),
           "Arm is refused");
    Ticks ticks;
    for (std::size_t i = 0; i < fire.size(); ++i)
      if (fire[i]) ticks.push_back(first + i);
    return ticks;
  }
  double energy_mj() { return driver().identity().max_energy_mj; }
  void ExpectFired(const Ticks& expected, const std::string& rule) {
    const Ticks fired = rig_->FiredTicks();
    Expect(fired == expected,
           fmt::format("{}: fired at {}, not at {}", rule, fired, expected));
  }
  void ExpectNoPulseFor(milliseconds time, const std::string& rule) {
    const Ticks before = rig_->FiredTicks();
    StepFor(time);
    ExpectFired(before, rule);
  }
  /// How a pulse is reported.
  link::TickOutcome fired() const {
    return rig_->sees_cracks() ? link::TickOutcome::kFiredSeen
                               : link::TickOutcome::kFiredUnseen;
  }
  /// Outcomes of all reports but of this bench's idle ticks, which have to follow each
  /// other; late ones are apart.
  std::map<std::uint64_t, link::TickOutcome> Outcomes();
  /// What the controller remembers of a stretch is what it did.
  void ExpectRemembers(std::uint64_t first, std::uint16_t count);
  /// Prepared anew it fires what is armed, and nothing else.
  void ExpectGoodWindow();

 private:
  void DecideIdleUpTo(std::uint64_t last);

  std::unique_ptr<LaserRig> rig_;
  std::set<std::uint64_t> idle_;
  std::uint64_t steps_ = 0, idle_session_ = 0, idle_through_ = 0, idle_until_ = 0;
};

}  // namespace intaglio::drivers
