#pragma once

// The stage and its controller: executes runs of position-velocity-time segments on the
// clock of the lamp's ticks, and lags behind what is commanded. Machine frame, mm.
//
//   rest --BeginRun--> waiting for the start tick --> running --end of program--> rest
//                                                       |  fault, abort
//                                                       +----> braking ----> rest
//
// Not thread-safe; time is what AdvanceTick says.

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "engrave/core/geometry.h"
#include "services/link/motion_protocol.h"

namespace intaglio::virtual_engraver {

struct StageOptions {
  Vec3 travel_min_mm = Vec3::Zero();
  Vec3 travel_max_mm = Vec3::Constant(170);
  double lag_s = 0.0002;                ///< first order, each axis; 0: none
  double position_tolerance_mm = 0.01;  ///< of the in-position output, distance
  double following_error_limit_mm = 1;  ///< beyond it the stage stops with a fault
  double brake_acceleration_mm_s2 = 7000;
  std::uint32_t queue_capacity = 4096;  ///< segments
  bool waits_for_motion = false;        ///< lockstep: an empty queue is no fault
};

class Stage {
 public:
  explicit Stage(const StageOptions& options);

  void BeginRun(const link::BeginRun& run);
  void Append(const link::Segments& segments);
  void Abort() { Brake(link::StageFault::kNone); }
  /// Stops the stage, with a fault that has to be reset.
  void Fail(link::StageFault fault) { Brake(fault); }
  void Reset();
  /// An axis that does not move any more (-1: all of them), until Unstick.
  void Stick(int axis);
  void Unstick() { stuck_ = {false, false, false}; }

  /// Whether the tick after the present one may pass in lockstep: motion for it is here,
  /// or none is to come.
  bool MayPass() const;
  /// One tick of 1 / rate_hz later. Latches the position while a run is executed.
  void AdvanceTick(double rate_hz);

  /// At the present tick: a segment marked for a pulse ends here, and the stage is there.
  bool in_position() const { return in_position_; }
  const Vec3& actual_mm() const { return actual_mm_; }
  bool running() const { return phase_ != Phase::kRest; }
  link::StageFault fault() const { return fault_; }
  link::MotionStatus Report();
  link::MotionIdentity Identity() const;
  /// Positions latched since the last call.
  std::vector<link::Positions> TakePositions();

 private:
  enum class Phase { kRest, kRunning, kBraking };
  struct Curve {  // from a knot: p + v s + c2 s^2 + c3 s^3, s seconds
    Vec3 p = Vec3::Zero(), v = Vec3::Zero(), c2 = Vec3::Zero(), c3 = Vec3::Zero();
  };
  static Curve CurveOf(const Vec3& p0, const Vec3& v0, const Vec3& p1, const Vec3& v1,
                       double duration_s);
  void Brake(link::StageFault fault);
  void FollowCurve(const Curve& curve, double from_s, double to_s);
  /// At most `subticks`; what the queue did not cover is returned.
  std::uint64_t FollowQueue(std::uint64_t subticks, double rate_hz);
  void RunTick(double rate_hz);
  void FinishSegment();
  void Latch();

  StageOptions options_;
  Phase phase_ = Phase::kRest;
  link::StageFault fault_ = link::StageFault::kNone;
  std::uint64_t tick_ = 0;
  double rate_hz_ = 1;
  std::uint32_t run_ = 0;
  std::uint64_t start_tick_ = 0;
  std::uint64_t taken_ = 0;
  std::deque<link::WireSegment> queue_;
  std::uint64_t queued_subticks_ = 0;      // of the whole queue
  std::uint64_t in_segment_subticks_ = 0;  // done of its first segment
  Vec3 knot_mm_ = Vec3::Zero(), knot_mm_s_ = Vec3::Zero();
  Vec3 commanded_mm_ = Vec3::Zero(), commanded_mm_s_ = Vec3::Zero();
  Vec3 actual_mm_ = Vec3::Zero();
  std::array<bool, 3> stuck_ = {false, false, false};
  bool in_position_ = false;
  double following_error_max_mm_ = 0;
  std::vector<link::Positions> latched_;
};

}  // namespace intaglio::virtual_engraver
