#pragma once

// The parts that the discretizing of one attempt of a job is cut into, for several
// discretizers at the same time: what each part's state is, and which is given next.
// Values only: no bus, no clock.
//
//   open --Give--> at work --Finish--> done
//     ^--Lose, LoseAhead: attempt + 1--|
//
// 1. A part has at most one worker; a report counts only if IsCurrent: it is of
//    that worker, about the newest attempt at a part that is not done.
// 2. A done part stays done.
// 3. An attempt's number is never used for two workers.
// 4. Less than the whole is reported as done until the last part is.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/job_service/records/task_id.h"

namespace intaglio::job_service {

/// One part. A part given ahead waits at its worker until the one before has ended. If it
/// is lost there, this does not count as a loss of the part.
struct PartRecord {
  std::string worker;         ///< empty: open
  std::uint32_t attempt = 0;  ///< in this attempt of the job
  std::uint32_t losses = 0;   ///< while it was worked on
  bool done = false;
  std::uint64_t done_count = 0;  ///< of total_count, in units of its own
  std::uint64_t total_count = 0;
  Nanoseconds not_before{0};  ///< when it may be given again

  bool open() const { return !done && worker.empty(); }
  bool at_work() const { return !done && !worker.empty(); }
};

/// Number of parts for this number of discretizers: one for one; else so many that a
/// discretizer that is slow or ends last is waited for at most an eighth of its share.
std::uint32_t PartCountFor(std::size_t discretizers);

class JobParts {
 public:
  /// Another attempt of the job, at this time: all parts are open.
  void Cut(std::size_t discretizers, Nanoseconds now);
  /// Handed out by an earlier run of the job service.
  void Restore(std::uint32_t part, std::uint32_t attempt, const std::string& worker);

  bool empty() const { return parts_.empty(); }
  std::size_t size() const { return parts_.size(); }
  /// Throw for a part that there is not.
  const PartRecord& at(std::size_t part) const { return parts_.at(part); }
  const PartRecord& operator[](std::size_t part) const { return parts_.at(part); }
  auto begin() const { return parts_.begin(); }
  auto end() const { return parts_.end(); }

  /// First open part that may be given now.
  std::optional<std::uint32_t> NextOpen(Nanoseconds now) const;
  /// First open part that may wait at a worker which is at another one. None towards the
  /// end, when no more parts are open than workers are at work: a part that waits while
  /// another discretizer is idle would cost what it saves. A part that was lost before is
  /// not given ahead: kMaxPartLosses counts on it.
  std::optional<std::uint32_t> NextAhead() const;
  void Give(std::uint32_t part, const std::string& worker);

  bool IsCurrent(const std::string& worker, std::uint32_t part,
                 std::uint32_t attempt) const;
  void SetProgress(std::uint32_t part, std::uint64_t done_count,
                   std::uint64_t total_count);
  void Finish(std::uint32_t part);

  /// Lost while it was worked on: it is open for another attempt from `not_before` on.
  void Lose(std::uint32_t part, const std::string& why, Nanoseconds not_before);
  /// Lost while it waited. It may yet be begun by a worker that only seems to be gone, so
  /// the attempt's number is used up.
  void LoseAhead(std::uint32_t part);

  bool all_done() const;
  bool any_at_work() const;
  /// "part 3 of 16".
  std::string NameOf(std::uint32_t part) const;
  /// Why a part began again, the last time; empty: none did.
  const std::string& last_loss() const { return last_loss_; }

  struct Progress {
    std::uint64_t done_count = 0;  ///< shares of the work; once all are done, of points
    std::uint64_t total_count = 0;
    double elapsed_s = 0;
  };
  Progress ProgressAt(Nanoseconds now) const;

 private:
  std::vector<PartRecord> parts_;
  std::string last_loss_;
  Nanoseconds begun_at_{0};
};

}  // namespace intaglio::job_service
