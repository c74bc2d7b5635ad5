#pragma once

// The marks that are on their way: journaled, then handed to the driver within its room,
// and settled by its events. Also settles what a halt or an earlier life left open.
// Used from one thread; nothing waits.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "engrave/mark/mark.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/marker/mark_record.h"

namespace intaglio::marker {

class MarkRun {
 public:
  /// Intents ahead of the controller: a disk that takes 50 ms for each sync keeps up with
  /// marks of a fifth of a millisecond. All of them are uncertain when host and
  /// controller lose their power together, so there are not more than this time of marks,
  /// a millisecond each at least, or two.
  static constexpr std::size_t kMaxArmed = 256, kMinArmed = 2;
  static constexpr double kArmedAheadS = 0.25;
  /// For a controller that remembers no marks: nobody knows of all that are armed what
  /// became of them when this process dies. A disk's sync between two marks is the price.
  static constexpr std::size_t kMaxArmedUnremembered = 1;
  /// For the answer of a controller that was asked, and how often it is. On a busy
  /// computer its process may not have run in this time: it has sent so many statuses,
  /// behind which the answer would have come, or it is waited for ten times as long.
  static constexpr std::chrono::milliseconds kAnswerTime{1000};
  static constexpr std::uint64_t kAnswerStatuses = 10;
  static constexpr int kMaxQuestions = 3;

  /// All outlive this. `eye`: the repeats of the web begin at print marks.
  MarkRun(const mark::MarkSet& set, const std::optional<drivers::PrintEye>& eye,
          drivers::MarkDriver& driver, MarkRecord& record)
      : set_(set), eye_(eye), driver_(driver), record_(record) {}

  /// Marks of an earlier life, armed in the record: they may have been handed over.
  void TakeUp(const std::vector<ArmedMark>& armed);
  /// True when the mark has become uncertain by it.
  bool Receive(const drivers::MarkEvent& event);

  /// With a photo eye, before a run: what is open of a repeat that was begun is left out,
  /// for its place on the web has gone. With nothing armed. False: the journal's ring is
  /// full.
  bool LeaveOutBegunRepeats();
  /// A run from the first open mark on. With nothing armed.
  Status Begin();
  /// Arms and hands over what there is room for, and finishes the run behind the last
  /// open mark. An error of the driver: it refuses a mark that it has room for.
  Status Turn();
  /// The run was finished, and all that was handed over has ended.
  bool is_over() const { return finished_ && armed_.empty(); }
  std::uint32_t count() const { return count_; }
  std::uint64_t session() const { return session_; }

  /// Nothing more is handed over: what was not is skipped, for it cannot be made.
  void End();
  bool all_settled() const { return armed_.empty(); }
  /// Asks a controller that is up and settled about what is armed, or gives up,
  /// and then it is uncertain. Returns the number of marks that became uncertain.
  std::uint64_t Settle(std::chrono::nanoseconds now);
  /// Counts marks made that only the controller's memory knows.
  std::uint64_t settled_by_memory_count() const { return by_memory_; }

 private:
  struct Armed {
    std::uint32_t run = 0;
    std::uint64_t journaled_at = 0;  ///< durable when so many records are
    bool handed = false;
    double time_s = 0;
  };
  void ArmMore();
  double SecondsOf(std::uint32_t mark) const;
  Status HandOver();
  void Ask();
  bool NeverCame(const drivers::MarkEvent& event) const;
  std::uint64_t GiveUp();

  const mark::MarkSet& set_;
  std::optional<drivers::PrintEye> eye_;
  drivers::MarkDriver& driver_;
  MarkRecord& record_;
  std::map<std::uint32_t, Armed> armed_;  // by mark
  std::uint32_t next_ = 0;                // mark to arm
  std::uint32_t next_handed_ = 0;
  bool finished_ = false;
  std::uint32_t count_ = 0;
  std::uint64_t session_ = 0;
  // They belong to settling.
  std::uint64_t asked_session_ = 0;
  int questions_ = 0;
  std::chrono::nanoseconds ask_again_at_{0};
  std::uint64_t asked_at_status_ = 0;
  std::map<std::uint32_t, std::uint32_t> known_;  // of each run, the newest it knows
  std::uint64_t by_memory_ = 0;
};

}  // namespace intaglio::marker
