#pragma once

// The driver of the grbl family in a run on a virtual grbl, fed as a synchronizer does.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tests/services/drivers/grbl/grbl_rig.h"

namespace intaglio::drivers {

/// A run along points 0.3 mm apart on a winding way, all of them armed.
class GrblCell {
 public:
  explicit GrblCell(grbl::VirtualGrblOptions options = grbl::Grbl11())
      : machine(std::move(options)), driver(machine.MakeDriver("")) {}
  /// Half the setting makes 4 mJ, all of it 10 mJ.
  void Calibrate() {
    for (const auto& [ratio, mj] : {std::pair(0.5, 4.0), std::pair(1.0, 10.0)}) {
      EnergyPoint& point = *machine.profile.mutable_laser()->add_energy_calibration();
      point.set_setting_ratio(ratio);
      point.set_energy_mj(mj);
    }
    driver = machine.MakeDriver("");
  }

  void Step() {
    machine.Advance();
    driver->Poll(
        [this](const link::PulseReport& report) {
          for (std::size_t i = 0; i < report.outcome.size(); ++i) {
            if (report.outcome[i] == link::TickOutcome::kNotArmed) continue;
            EXPECT_TRUE(outcomes.emplace(report.first_tick + i, report.outcome[i]).second)
                << "tick " << report.first_tick + i << " is reported twice";
          }
        },
        [](const link::PastReport&) {});
    (void)driver->TakePositions();
    Feed();
  }
  bool Until(const std::function<bool()>& condition, int limit_ms = 60000) {
    for (int i = 0; i < limit_ms && !condition(); ++i) Step();
    return condition();
  }
  void Prepare() {
    ASSERT_TRUE(Until([&] { return driver->up(); })) << driver->message();
    ASSERT_TRUE(driver->Reset() && driver->Lamp(true, kGrblRateHz) &&
                driver->OpenShutters(1));
    ASSERT_TRUE(Until([&] {
      return driver->Has(link::kLampWarm) && driver->status().shutters_open == 1 &&
             driver->state().at_rest;
    })) << driver->state().message;
  }
  /// Points of which each is `pitch_mm` from the next one, ticks_a_point apart.
  void Begin(int count, double pitch_mm, bool stops) {
    const Vec3 from = driver->state().position_mm;
    const std::uint64_t start =
        std::max(driver->status().tick, driver->status().decided_through) + 3;
    ASSERT_TRUE(driver->BeginRun(++run, start, 0)) << driver->state().message;
    const double speed = pitch_mm * kGrblRateHz / ticks_a_point;
    for (int i = 1; i <= count; ++i) {
      motion::Segment segment;
      const double turn = 0.3 * i;
      const Vec3 along(std::cos(0.2 * turn), std::sin(0.2 * turn), 0.1);
      const Vec3 last = points.empty() ? from : points.rbegin()->second;
      segment.end_position_mm = last + along * pitch_mm / along.norm();
      if (!stops && i < count) segment.end_velocity_mm_s = along * speed / along.norm();
      segment.duration_subticks = ticks_a_point * motion::kSubticksPerTick;
      segment.pulse = true;
      segment.program_end = i == count;
      points[start + ticks_a_point * static_cast<std::uint64_t>(i)] =
          segment.end_position_mm;
      segments.push_back(segment);
    }
    armed_through = start;
    last_tick = start + ticks_a_point * static_cast<std::uint64_t>(count);
    ASSERT_TRUE(driver->Arm({start - 2, true, {false, false, false}}));
  }
  /// As a synchronizer: never more than 16 points armed and not reported.
  void Feed() {
    while (!segments.empty() && driver->Room() > 0) {
      ASSERT_TRUE(driver->Append(std::span(segments).first(1), {}));
      segments.erase(segments.begin());
    }
    if (!feeds || !driver->up()) return;
    std::vector<bool> fire(ticks_a_point, false);
    fire.back() = true;
    while (armed_through < last_tick && Open() < GrblDriver::kMaxUnsettled) {
      ASSERT_TRUE(driver->Arm({armed_through + 1, true, fire, false,
                               energies_mj.empty()
                                   ? energy_mj
                                   : energies_mj[armed_count % energies_mj.size()]}));
      armed_through += ticks_a_point;
      ++armed_count;
    }
  }
  std::size_t Open() const {
    std::size_t open = 0;
    for (const auto& [tick, place] : points) {
      open += tick <= armed_through && outcomes.count(tick) == 0;
    }
    return open;
  }
  bool RunIsOver() { return armed_through >= last_tick && driver->state().at_rest; }

  GrblMachine machine;
  std::unique_ptr<GrblDriver> driver;
  std::map<std::uint64_t, Vec3> points;
  std::map<std::uint64_t, link::TickOutcome> outcomes;
  std::vector<motion::Segment> segments;
  std::uint64_t armed_through = 0, last_tick = 0;
  std::uint32_t run = 0;
  std::uint64_t ticks_a_point = 4;
  double energy_mj = 10;
  std::vector<double> energies_mj;  // of the points, again and again; empty: energy_mj
  std::size_t armed_count = 0;
  bool feeds = true;
};

}  // namespace intaglio::drivers
