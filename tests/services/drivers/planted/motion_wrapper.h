#pragma once

// A motion driver that passes everything on to another one: what a test changes of a good
// driver is all that differs. Its laser side is not passed on.

#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "services/drivers/interface/motion_driver.h"

namespace intaglio::drivers {

class MotionWrapper : public MotionDriver {
 public:
  explicit MotionWrapper(std::unique_ptr<MotionDriver> inner)
      : inner_(std::move(inner)) {}
  void Poll() override { inner_->Poll(); }
  int fd() const override { return inner_->fd(); }
  const DriverState& state() const override { return inner_->state(); }
  std::vector<LatchedPositions> TakePositions() override {
    return inner_->TakePositions();
  }
  Status BeginRun(std::uint32_t run, std::uint64_t tick, std::uint64_t ns) override {
    return inner_->BeginRun(run, tick, ns);
  }
  Status RequireBlockAt(const Vec2& place_mm) override {
    return inner_->RequireBlockAt(place_mm);
  }
  std::size_t Room() const override { return inner_->Room(); }
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    return inner_->Append(segments, end_ns);
  }
  Status AbortRun() override { return inner_->AbortRun(); }
  Status ClearFault() override { return inner_->ClearFault(); }
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    return inner_->Jog(axes, speed_mm_s);
  }
  Status Home() override { return inner_->Home(); }
  Status SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) override {
    return inner_->SetZero(here_mm, sets);
  }
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override {
    return inner_->DrawOutline(corners_mm, speed_mm_s);
  }
  Status MoveBlock(const Vec2& place_mm, double speed_mm_s) override {
    return inner_->MoveBlock(place_mm, speed_mm_s);
  }
  Status Hold() override { return inner_->Hold(); }

 protected:
  std::unique_ptr<MotionDriver> inner_;
};

}  // namespace intaglio::drivers
