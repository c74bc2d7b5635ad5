#pragma once

// A rig in the middle of a check, and the courses that it drives: all along x, up to
// 10 mm/s within 5 ticks, some ticks at that speed, and to rest within 5 ticks. Their
// oracle is the cubic Hermite polynomial, written here once more, from p0 at the velocity
// v0 to p1 at v1 in T:
//   p(u T) = (2u^3 - 3u^2 + 1) p0 + (u^3 - 2u^2 + u) T v0 + (3u^2 - 2u^3) p1
//          + (u^3 - u^2) T v1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/drivers/rig_expect.h"

namespace intaglio::drivers {

inline constexpr double kSpeed_mm_s = 10;
inline constexpr std::uint32_t kRampTicks = 5;

inline motion::Segment To(double x_mm, double vx_mm_s, std::uint32_t ticks,
                          bool end = false) {
  motion::Segment segment;
  segment.end_position_mm = Vec3(x_mm, 0, 0);
  segment.end_velocity_mm_s = Vec3(vx_mm_s, 0, 0);
  segment.duration_subticks = ticks * motion::kSubticksPerTick;
  segment.program_end = end;
  return segment;
}

/// From x0 on, in the direction of the sign of `speed`.
struct Course {
  double x0_mm = 0, speed_mm_s = kSpeed_mm_s, rate_hz = 100;
  std::uint32_t cruise_ticks = 20;

  double ramp_mm() const { return speed_mm_s * kRampTicks / rate_hz / 2; }
  double step_mm() const { return speed_mm_s / rate_hz; }
  std::uint32_t ticks() const { return cruise_ticks + 2 * kRampTicks; }
  double end_mm() const { return x0_mm + 2 * ramp_mm() + cruise_ticks * step_mm(); }
  std::vector<motion::Segment> Segments() const {
    std::vector<motion::Segment> all = {To(x0_mm + ramp_mm(), speed_mm_s, kRampTicks)};
    for (std::uint32_t i = 1; i <= cruise_ticks; ++i)
      all.push_back(To(x0_mm + ramp_mm() + i * step_mm(), speed_mm_s, 1));
    all.push_back(To(end_mm(), 0, kRampTicks, true));
    return all;
  }
  /// Where the stage has to be so many ticks after the start.
  double At(std::uint32_t tick) const {
    const double T = kRampTicks / rate_hz, d = ramp_mm(), v = speed_mm_s;
    if (tick <= kRampTicks) {
      const double u = static_cast<double>(tick) / kRampTicks;
      return x0_mm + (3 * u * u - 2 * u * u * u) * d + (u * u * u - u * u) * T * v;
    }
    if (tick <= kRampTicks + cruise_ticks)
      return x0_mm + d + (tick - kRampTicks) * step_mm();
    const double u = static_cast<double>(tick - kRampTicks - cruise_ticks) / kRampTicks;
    return end_mm() - d + (u * u * u - 2 * u * u + u) * T * v +
           (3 * u * u - 2 * u * u * u) * d;
  }
};

/// A rig in the middle of a check, and what its driver reported of positions.
class MotionBench {
 public:
  explicit MotionBench(const MotionRigMaker& make, const std::string& serial_number = "")
      : rig_(make(serial_number)) {}
  void Connect() { Expect(rig_->Connect(), "the line does not come up: " + Message()); }

  MotionRig& rig() { return *rig_; }
  MotionDriver& driver() { return *rig_->driver; }
  const DriverState& state() { return driver().state(); }
  std::string Message() { return state().message; }
  double x() { return rig_->actual_mm().x(); }

  void Step() {
    rig_->Step();
    for (auto& latched : driver().TakePositions())
      positions.push_back(std::move(latched));
    const Vec3 at_mm = rig_->actual_mm();
    const Box3 travel{rig_->travel_min_mm(), rig_->travel_max_mm()};
    const bool inside = (at_mm.array() >= travel.min_mm.array()).all() &&
                        (at_mm.array() <= travel.max_mm.array()).all();
    Expect(inside, "M7: the stage has left its travel");
  }
  void StepFor(milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) Step();
  }
  bool Until(const std::function<bool()>& condition,
             milliseconds limit = std::chrono::seconds(3)) {
    for (std::int64_t i = 0; i < limit.count() && !condition(); ++i) Step();
    return condition();
  }

  Course CourseFromHere() {
    Course course;
    course.x0_mm = x();
    course.rate_hz = rig_->rate_hz();
    return course;
  }
  void Append(std::vector<motion::Segment> segments) {
    while (!segments.empty()) {
      Expect(Until([&] { return driver().Room() > 0; }),
             "M1: there is never room for a segment: " + Message());
      const auto count = std::min(driver().Room(), segments.size());
      Expect(AppendAtOnce(std::span(segments).first(count)), "Append");
      segments.erase(segments.begin(),
                     segments.begin() + static_cast<std::ptrdiff_t>(count));
    }
  }
  /// As MotionDriver::Append and BeginRun, with the times of a clock of its own where the
  /// controller has one.
  Status AppendAtOnce(std::span<const motion::Segment> segments) {
    std::vector<std::uint64_t> end_ns;
    std::uint64_t subticks = subticks_;
    for (const motion::Segment& segment : segments) {
      subticks += segment.duration_subticks;
      const double ticks = static_cast<double>(subticks) / motion::kSubticksPerTick;
      end_ns.push_back(start_ns_ + static_cast<std::uint64_t>(ticks * rig_->tick_ns()));
    }
    if (start_ns_ == 0) end_ns.clear();
    auto appended = driver().Append(segments, end_ns);
    if (appended) subticks_ = subticks;
    return appended;
  }
  Status BeginAt(std::uint32_t run, std::uint64_t tick) {
    start_ns_ = rig_->NsOfTick(tick);
    subticks_ = 0;
    return driver().BeginRun(run, tick, start_ns_);
  }
  /// Begins 200 ms from now.
  std::uint64_t Begin(std::uint32_t run) {
    const auto lead = static_cast<std::uint64_t>(0.2 * rig_->rate_hz());
    const std::uint64_t start = state().tick + lead;
    Expect(BeginAt(run, start), "BeginRun");
    return start;
  }
  /// A course of a second, of which 0.5 s have passed.
  void MoveALot(std::uint32_t run) {
    Course course = CourseFromHere();
    course.cruise_ticks = 50;
    Begin(run);
    Append(course.Segments());
    Expect(Until([&] { return std::abs(x() - course.x0_mm) > 2; }),
           "M3: the run does not begin: " + Message());
  }
  bool RestsWithin(milliseconds time) {
    return Until([&] { return !rig_->moves(); }, time + rig_->braking_time());
  }
  void ExpectStill(milliseconds time, const std::string& violation) {
    const Vec3 place = rig_->actual_mm();
    for (std::int64_t i = 0; i < time.count(); ++i) {
      Step();
      Expect(rig_->actual_mm() == place, violation);
    }
  }
  void ExpectFault(intaglio_MotionFault fault, const std::string& what) {
    Expect(Until([&] { return state().fault == fault; }, kSilence + kReportTime),
           fmt::format("{}: the fault is {}, not {}", what,
                       static_cast<int>(state().fault), static_cast<int>(fault)));
    Expect(!Message().empty(), what + ": the fault has no message");
  }
  void ClearFault() {
    Expect(driver().ClearFault(), "ClearFault");
    ExpectStill(kReportTime, "M6: ClearFault moves the stage");
    Expect(state().fault == intaglio_MOTION_OK,
           "M6: ClearFault does not clear the fault");
  }
  /// As a person does where the place of the axes may be lost; run `refused` is before.
  void StatePlace(std::uint32_t refused) {
    if (state().place_lost.empty() && state().homed) return;
    Begin(refused);
    ExpectFault(intaglio_MOTION_SAFE_STATE, "M18: a run where the place may be lost");
    Expect(state().run == refused, "M18: the fault of a run is without its number");
    ExpectStill(milliseconds(500), "M18: a run begins where the place may be lost");
    ClearFault();
    if (!state().homed) return Expect(rig_->FindPlace(), "M18: Home does not end");
    Expect(driver().SetZero(rig_->actual_mm(), {true, true, true}), "SetZero");
    Expect(!state().at_rest, "M18: at rest before the place is stated");
    Expect(Until([&] { return state().at_rest; }), "M18: SetZero does not end");
    Expect(state().place_lost.empty(), "M18: the place stays lost: " + Message());
  }
  /// All of a course, as its oracle has it.
  void ExpectGoodRun(std::uint32_t run);

  std::vector<LatchedPositions> positions;

 private:
  std::unique_ptr<MotionRig> rig_;
  std::uint64_t start_ns_ = 0, subticks_ = 0;  // of the newest run, and of its segments
};

}  // namespace intaglio::drivers
