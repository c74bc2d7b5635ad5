#pragma once

// A laser rig in the middle of a check.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
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
    for (std::int64_t i = 0; i < time.count(); ++i) rig_->Step();
  }
  bool Until(const std::function<bool()>& condition,
             milliseconds limit = std::chrono::seconds(3)) {
    for (std::int64_t i = 0; i < limit.count() && !condition(); ++i) rig_->Step();
    return condition();
  }
  void PassTicks(std::uint64_t count) {
    const std::uint64_t end = tick() + count;
    Expect(Until([&] { return tick() >= end; }, milliseconds(1000 + 20 * count)),
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
    Expect(driver().Arm({first, gated, fire}).has_value(), "Arm is refused");
    Ticks ticks;
    for (std::size_t i = 0; i < fire.size(); ++i)
      if (fire[i]) ticks.push_back(first + i);
    return ticks;
  }
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
  /// Outcomes of all reports, which have to follow each other; late ones are apart.
  std::map<std::uint64_t, link::TickOutcome> Outcomes();
  /// What the controller remembers of a stretch is what it did.
  void ExpectRemembers(std::uint64_t first, std::uint16_t count);
  /// Prepared anew it fires what is armed, and nothing else.
  void ExpectGoodWindow();

 private:
  std::unique_ptr<LaserRig> rig_;
};

}  // namespace intaglio::drivers
