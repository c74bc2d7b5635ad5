#pragma once

// A motion bridge with its stage: takes the feed's batches after a while, grants credit,
// moves exactly as the segments describe, and shows itself in a MotionView that is some
// milliseconds old. The test controls every fault.

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "idl/motion.h"
#include "services/platform/bus/flow.h"
#include "services/synchronizer/engraving.h"

namespace intaglio::synchronizer {

class FakeStage {
 public:
  static constexpr std::uint32_t kSubticks = 65536;
  static constexpr std::size_t kQueueSegments = 200;
  static constexpr std::uint64_t kWindowBatches = 16;

  /// What MotionFeed writes to and asks.
  Status Receive(const intaglio_MotionSegmentBatch& batch, std::chrono::nanoseconds now);
  bus::CreditBook::Grant GrantOf(const std::string& stream) const;

  /// The bridge's turn; `tick` is the newest one of the lamp.
  void Poll(std::chrono::nanoseconds now, std::uint64_t tick);
  void AdvanceTick(std::uint64_t tick);
  /// In lockstep no tick passes for which the motion is still to come.
  bool MayPassTick(std::uint64_t next_tick) const;

  bool in_position() const { return in_position_ && !behind; }
  bool running() const { return running_; }
  const Vec3& at_mm() const { return at_mm_; }
  const MotionView& view() const { return view_; }
  std::uint64_t queued_through_tick() const;

  /// By a clock of its own: a run in hand goes on over lamp syncs that do not come.
  void MoveOn(std::uint64_t ticks) { start_tick_ -= running_ ? ticks : 0; }
  /// The stage stops where it is.
  void Fail(intaglio_MotionFault fault, const std::string& message);

  std::chrono::milliseconds latency{3};  ///< of a batch
  bool silent = false;                   ///< its state is not published
  bool behind = false;                   ///< following error: never in position
  bool deaf = false;                     ///< batches wait in front of it
  std::uint64_t braking_ticks = 0;       ///< that it moves on when a run is broken off

 private:
  struct Segment {
    Vec3 end_mm;
    std::uint32_t duration_subticks;
    bool pulse, program_end;
  };
  struct Batch {
    std::chrono::nanoseconds due;
    std::string stream;
    std::uint32_t run;
    std::uint64_t number, start_tick;
    bool abort;
    std::vector<Segment> segments;
  };
  void Accept(Batch batch, std::uint64_t tick);
  void BreakOff();
  void EndRun();

  std::deque<Batch> arriving_;
  std::deque<Batch> taken_;  // wait for room in the queue
  std::deque<Segment> queue_;
  bus::CreditBook::Grant grant_;
  std::string stream_;
  std::uint32_t run_ = 0, begun_run_ = 0, highest_run_ = 0;
  std::uint64_t expected_ = 0;
  std::uint64_t start_tick_ = 0;
  std::uint64_t queued_subticks_ = 0, passed_subticks_ = 0;
  std::uint64_t ticks_to_rest_ = 0;
  bool running_ = false, ending_ = false, in_position_ = false;
  Vec3 at_mm_ = Vec3::Zero();
  intaglio_MotionFault fault_ = intaglio_MOTION_OK;
  std::string message_;
  std::chrono::nanoseconds next_view_{0};
  std::chrono::nanoseconds rest_at_{0}, now_{0};
  MotionView view_;
};

}  // namespace intaglio::synchronizer
