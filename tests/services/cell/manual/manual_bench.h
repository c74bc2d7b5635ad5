#pragma once

// ManualControl before a stage that does what the test says.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/cell/manual/manual_control.h"

namespace intaglio::cell {

using namespace std::chrono_literals;
using Nanoseconds = std::chrono::nanoseconds;

/// A stage that does what the test says, and remembers what it was told to do.
class FakeDriver final : public drivers::HandMotion {
 public:
  const drivers::DriverState& state() const override { return now; }
  Status Hold() override {
    ++holds;
    return {};
  }
  Status ClearFault() override {
    ++clears;
    return {};
  }
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    ++jogs;
    target = axes;
    speed = speed_mm_s;
    now.at_rest = false;
    return {};
  }

  Status MoveBlock(const Vec2& place_mm, double speed_mm_s) override {
    ++block_moves;
    target = Vec3(place_mm.x(), place_mm.y(), 0);
    speed = speed_mm_s;
    now.at_rest = false;
    return {};
  }

  Status SetZero(const Vec3& here, const std::array<bool, 3>& sets) override {
    ++zeros;
    target = here;
    set_axes = sets;
    now.at_rest = false;
    return {};
  }

  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    ++outlines;
    corners.assign(corners_mm.begin(), corners_mm.end());
    speed = speed_mm_s;
    now.at_rest = false;
    return {};
  }

  drivers::DriverState now;
  int outlines = 0;
  std::vector<Vec2> corners;
  std::array<bool, 3> set_axes{};
  int zeros = 0, block_moves = 0;
  int jogs = 0, holds = 0, clears = 0;
  Vec3 target = Vec3::Zero();
  double speed = 0;
};

class ManualControlTest : public ::testing::Test {
 protected:
  ManualControlTest()
      : control_(driver_, {Vec3::Zero(), Vec3(100, 80, 60)}, {"x", "y", "z"}) {
    driver_.now.link_up = driver_.now.at_rest = true;
    driver_.now.fault = intaglio_MOTION_OK;
    driver_.now.position_mm = Vec3(10, 10, 10);
    conditions_.permission_fresh = true;
    conditions_.key_on = conditions_.door_closed = conditions_.stop_released = true;
    conditions_.laser_line_up = true;
    Publish();
  }

  void Publish() { control_.NotePublished(++number_, now_); }
  /// Sends key, door and stop, as long as the test wants them.
  void Turn() {
    if (are_reported_) conditions_.interlocks_at = now_;
    control_.Turn(conditions_, now_);
  }
  /// The order of this number, from 1, of those that begin at the first state.
  ManualOrder Jog(std::uint64_t number, const std::string& sender = "ann") const {
    return {sender, kBefore + number, number_, intaglio_MANUAL_JOG, Vec3(1, 0, 0), 20};
  }
  void Give(const ManualOrder& order) {
    control_.Receive(order, now_);
    Turn();
  }
  void BeginJog() {
    Give(Jog(1));
    ASSERT_EQ(driver_.jogs, 1);
    ASSERT_TRUE(control_.moves());
  }
  void ComeToRest() {
    driver_.now.at_rest = true;
    Turn();
  }

  FakeDriver driver_;
  ManualControl control_;
  ManualConditions conditions_;
  Nanoseconds now_ = 10s;
  bool are_reported_ = true;
  /// The number before the first state.
  static constexpr std::uint64_t kBefore = 1000;
  std::uint64_t number_ = kBefore;
};

}  // namespace intaglio::cell
