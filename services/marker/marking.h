#pragma once

// The states of a job at a machine that marks.
//
//   kWaiting --all links hold, settled, journal on disk--> kOpening --shutter--> kRunning
//      ^  ^                                                   |                    |  |
//      |  +---- settled: made, open again, or uncertain -- kHalting <--------------+  |
//      |                                                      ^   link lost, stop,    |
//      |                                                      |   fault, line         |
//      +--- the run has ended ------------------- kPausing <--+-----------------------+
//                                                   permission withdrawn: the mark in
//                                                   hand is ended first
//   kDone: nothing is open, and no arm has to be renewed by a person over a mark that is
//          uncertain; or it was stopped
//
// A permission that is late, not withdrawn, lets a machine that can_hold rest within the
// mark in hand, and the run goes on when it comes; any other machine halts, and that mark
// is uncertain.
//
// Nothing is handed to the driver whose intent is not on disk, and none while a link of
// the permission chain is missing. A mark that was begun and not ended is uncertain, as
// is one of which neither event nor memory tells: neither is made again without a
// person's consent (services/cell/consent.h). Used from one thread; no waits.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "services/cell/consent.h"
#include "services/cell/earlier_work.h"
#include "services/cell/grant_inputs.h"
#include "services/cell/permission_chain.h"
#include "services/cell/work_states.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/marker/mark_record.h"
#include "services/marker/mark_run.h"

namespace intaglio::marker {

struct MarkingJob {
  std::string uid;
  mark::MarkSet marks;  ///< in their order
  bool asks_when_uncertain = false;
  /// The repeats of the web begin at print marks; none: by the encoder alone.
  std::optional<drivers::PrintEye> eye = {};
  double max_web_mm_s = 0;  ///< at which all are made; 0: of a piece at rest
  cell::EarlierWork earlier = {};
};

/// The links of the permission chain as the inputs and the controller have them.
cell::ChainLinks LinksOf(const drivers::MarkDeviceState& state,
                         const cell::GrantInputs& inputs);

/// Why every arm is spent while this lasts, and what to do: another controller answers,
/// or it does not know where its tool is. Empty: arms count.
const std::string& WhyNoArmCounts(const drivers::MarkDeviceState& state);

class Marking final : public cell::WorkStates {
 public:
  enum class Phase { kWaiting, kOpening, kRunning, kPausing, kHalting, kDone };

  /// The controller is told that it may mark so often while it may.
  static constexpr std::chrono::milliseconds kPermitPeriod{20};
  static constexpr std::chrono::milliseconds kShutterTime{3000};
  /// A process that ends does not wait longer for what is open: the next one settles it.
  static constexpr std::chrono::milliseconds kStopTime{2000};
  /// Without any event; longer than twice the longest mark is added.
  static constexpr std::chrono::seconds kStallTime{30};

  /// All outlive this. `chain` has begun the job, and is turned by this from now on. The
  /// caller polls the driver.
  Marking(MarkingJob job, drivers::MarkDriver& driver, cell::JournalWriter& journal,
          cell::PermissionChain& chain);

  void Turn(const cell::GrantInputs& inputs);
  Phase phase() const { return phase_; }
  Activity activity() const override;
  const cell::PointLedger& ledger() const override { return record_.ledger(); }
  bool waits() const override {
    const bool works = phase_ == Phase::kRunning || phase_ == Phase::kOpening ||
                       phase_ == Phase::kPausing;
    return (started() || faulted()) && !works && !message_.empty();
  }
  std::uint32_t run_count() const override { return run_.count(); }
  std::uint64_t settled_by_memory_count() const override {
    return run_.settled_by_memory_count();
  }

 private:
  void TakeEvents(std::chrono::nanoseconds now);
  void SendPermit(std::chrono::nanoseconds now);
  void WatchProgress(std::chrono::nanoseconds now);

  void Wait(const cell::GrantInputs& inputs);
  /// A halt that a new arm ends, and not a line that comes back, leaves a mark uncertain.
  bool AwaitsPerson() const;
  bool MayMark(const cell::GrantInputs& inputs);
  bool WebIsTooFast();
  std::string_view WhatRunWaitsFor() const;
  void Open(const cell::GrantInputs& inputs);
  void Run(const cell::GrantInputs& inputs);
  void Pause(const cell::GrantInputs& inputs);
  /// Whether the run rests, because nothing but a fresh permission is missing.
  bool HoldsForLatePermission(const cell::GrantInputs& inputs);
  void Settle(const cell::GrantInputs& inputs);

  cell::Missing WhatIsMissing(const cell::GrantInputs& inputs,
                              bool with_permission) const;
  std::string TextFor(cell::Missing missing) const override;
  void Halt(cell::Missing missing, const std::string& text, bool fault,
            std::chrono::nanoseconds now);
  std::string Question() const override;

  MarkingJob job_;
  drivers::MarkDriver& driver_;
  MarkRecord record_;
  MarkRun run_;
  cell::Consent consent_;
  double longest_mark_s_ = 0;

  Phase phase_ = Phase::kWaiting;
  bool permitted_ = false;
  bool pause_sent_ = false;
  bool held_ = false;  ///< no permission is passed on
  std::chrono::nanoseconds permit_at_{0}, opening_since_{0}, stop_again_at_{0},
      stopping_since_{-1}, moved_at_{0};
};

}  // namespace intaglio::marker
