#pragma once

// What became of the marks of one job: ledger and journal (engrave/formats/journal_file)
// get every change from here alone, so they never disagree. A mark is to it what a point
// is to the record of pulses:
//
//   Arm      ledger: armed        journal: intent   (handed over once that is durable)
//   Resolve  ledger: the outcome  journal: outcome
//   Reopen   ledger: planned      journal: reopened, by a consent already there
//
// The `tick` of an intent and an outcome is the run; the power-up of a session record is
// the CRC-32 of the controller's text, 0 where it gives none.
//
// Used from one thread; nothing waits. Where a function returns bool, false means that
// the journal's ring is full and nothing has changed.

#include <cstdint>
#include <string>
#include <vector>

#include "services/cell/consent.h"
#include "services/cell/earlier_work.h"
#include "services/cell/journal_writer.h"
#include "services/cell/point_ledger.h"
#include "services/drivers/interface/mark_driver.h"

namespace intaglio::marker {

/// Makes a number of a controller's text, never 0; of an empty one 0.
std::uint32_t PowerUpNumber(const std::string& power_up);

struct ArmedMark {
  std::uint32_t run = 0;
  std::uint32_t mark = 0;
};

class MarkRecord final : public cell::UncertainPoints {
 public:
  MarkRecord(std::size_t mark_count, cell::JournalWriter& journal)
      : journal_(journal), ledger_(mark_count) {}

  /// Begins with what earlier lives left. Returns the marks whose intent is open, by
  /// their numbers: they are armed in the ledger, and the caller has to settle them.
  std::vector<ArmedMark> TakeUp(const cell::EarlierWork& earlier);

  const cell::PointLedger& ledger() const override { return ledger_; }
  std::uint32_t run() const { return run_; }
  /// Above `newest`, the controller's, which remembers the marks of runs by their
  /// numbers: those of earlier jobs, and of an earlier life that left no record of its
  /// run.
  std::uint32_t BeginRun(std::uint32_t newest);

  bool Arm(std::uint32_t mark);
  /// What became of an armed mark.
  void Resolve(std::uint32_t mark, formats::PointOutcome outcome,
               formats::MarkSkip why = formats::MarkSkip::kNone);
  /// Every open mark before this one, for good.
  bool LeaveOutBefore(std::uint32_t mark);
  /// An open mark, for good.
  bool LeaveOut(std::uint32_t mark, formats::MarkSkip why);
  bool KeepConsent(std::uint64_t grant_number) override;
  bool Reopen(std::uint32_t mark, std::uint64_t grant_number) override;

  std::uint32_t power_up() const { return power_up_; }
  /// What follows is of this power-up, and these openings of interlocks are known.
  bool KeepSession(std::uint32_t power_up, std::uint32_t openings);

  /// Everything appended so far is on disk.
  bool is_durable() const { return journal_.durable() == journal_.appended(); }
  std::uint64_t appended() const { return journal_.appended(); }
  std::uint64_t durable() const { return journal_.durable(); }
  bool disk_failed() const { return journal_.failed(); }
  std::string disk_error() const { return journal_.error(); }
  /// Flushes what was appended since the last call.
  void FlushAppended();

 private:
  cell::JournalWriter& journal_;
  cell::PointLedger ledger_;
  std::uint32_t run_ = 0;
  std::uint32_t power_up_ = 0, openings_ = 0;
  bool session_kept_ = false;
  std::uint64_t flushed_ = 0;
};

}  // namespace intaglio::marker
