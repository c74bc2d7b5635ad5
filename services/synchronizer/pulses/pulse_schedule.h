#pragma once

// Which tick fires which point, from the moment its motion is planned until the laser
// controller has reported what became of it. In the order of ticks; frame-free.

#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "services/platform/link/laser_protocol.h"

namespace intaglio::synchronizer {

/// Why a point was not fired; the numbers of intaglio_SkipReason (idl/laser.idl).
enum class SkipReason : std::uint8_t {
  kNone,
  kNoPermission,
  kInterlock,
  kLamp,
  kShutter,
  kPosition,
  kLate,
  kLink,
  kLeftOut,
  kTrigger,
  kEnergy,
};

/// What became of one armed point.
struct PulseResult {
  std::uint64_t tick = 0;
  std::uint32_t point = 0;
  formats::PointOutcome outcome = formats::PointOutcome::kNone;
  SkipReason reason = SkipReason::kNone;
  /// Bit 0..3: channels 1..4 whose photosensor saw no flash; 0 of a missed pulse: not
  /// known.
  std::uint8_t missed_channels = 0;
  float measured_mj = 0;  ///< energy of the pulse; 0: not measured
};

class PulseSchedule {
 public:
  using ResultSink = std::function<void(const PulseResult&)>;

  /// The stage is at `point` at `tick`; ticks grow.
  void Add(std::uint64_t tick, std::uint32_t point);

  /// Decides first..last: the window to send. `armed` gets every (tick, point) in it.
  /// Points planned for ticks before `first` can no longer be decided: they go to `late`
  /// and leave the schedule.
  link::ArmWindow Decide(std::uint64_t first, std::uint64_t last,
                         const std::function<void(std::uint64_t, std::uint32_t)>& armed,
                         const std::function<void(std::uint32_t)>& late);

  struct AlikeTicks {
    std::uint64_t last = 0;  ///< tick
    double value = 0;        ///< of its points; 0: it has none
  };
  /// From `first` the most ticks, through `last` at most, whose planned points have the
  /// same value.
  AlikeTicks AlikeFrom(std::uint64_t first, std::uint64_t last,
                       const std::function<double(std::uint32_t point)>& value_of) const;

  /// A point that an earlier life armed for this tick, with a result that is not known
  /// yet; before any Add. False: the tick does not follow the last one.
  bool AddArmed(std::uint64_t tick, std::uint32_t point);

  /// Takes the controller's report; ticks that were not armed here are ignored.
  void Apply(const link::PulseReport& report, const ResultSink& sink);
  /// Its memory of the past, after a Disarm: what it reports as not armed was not fired.
  void Apply(const link::PastReport& report, const ResultSink& sink);

  /// Armed points without a result whose tick is within first..last.
  std::vector<PulseResult> ArmedWithin(std::uint64_t first, std::uint64_t last) const;
  /// Points without a result, armed or not, whose tick is after this one.
  std::vector<PulseResult> OpenAfter(std::uint64_t tick) const;
  /// Gives them a result of the caller's.
  void Settle(const std::vector<PulseResult>& results, const ResultSink& sink);

  /// Forgets what is planned and not armed; the armed wait for their results.
  void DropUnarmed();

  /// Through which tick may be decided, so that no more than `count` points are armed
  /// without a result; UINT64_MAX: the planned ones are no more.
  std::uint64_t LastTickFor(std::size_t count) const;

  bool empty() const { return entries_.empty(); }
  std::size_t armed_count() const { return armed_count_; }
  /// Tick of the first entry without a result; 0 when empty.
  std::uint64_t front_tick() const {
    return entries_.empty() ? 0 : entries_.front().tick;
  }

 private:
  struct Entry {
    std::uint64_t tick = 0;
    std::uint32_t point = 0;
    bool armed = false;
    bool settled = false;
  };
  Entry* Find(std::uint64_t tick);
  void ApplyOne(link::TickOutcome outcome, PulseResult result, const ResultSink& sink);
  void SettleOne(Entry& entry, PulseResult result, const ResultSink& sink);
  void PopSettled();

  std::deque<Entry> entries_;
  std::size_t decided_ = 0;  // entries from the front that were armed
  std::size_t armed_count_ = 0;
};

}  // namespace intaglio::synchronizer
