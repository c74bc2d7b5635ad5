#pragma once

// How long a job has been at work, without what it waited for, of all processes that have
// made it.

#include <chrono>
#include <cstdint>
#include <optional>

namespace intaglio::cell {

class WorkClock {
 public:
  /// `is_at_work` since the turn before, with so many points or marks done until now.
  void Turn(std::chrono::nanoseconds now, bool is_at_work, std::uint64_t done) {
    if (is_at_work) {
      if (!earlier_done_) earlier_done_ = done;
      worked_ += now - turned_at_;
    }
    turned_at_ = now;
  }
  /// Nothing before it counts.
  void Begin(std::chrono::nanoseconds now) { turned_at_ = now; }

  /// How long earlier processes worked is not known: what they made counts as made at the
  /// pace of this one. Else all of it would seem to be made in the time of this one
  /// alone. 0 until this one has made something.
  double ElapsedSeconds(std::uint64_t done) const {
    const double worked_s = std::chrono::duration<double>(worked_).count();
    const std::uint64_t earlier = earlier_done_.value_or(0);
    if (earlier == 0) return worked_s;
    if (done <= earlier) return 0;
    return worked_s * static_cast<double>(done) / static_cast<double>(done - earlier);
  }

 private:
  std::chrono::nanoseconds turned_at_{0}, worked_{0};
  std::optional<std::uint64_t> earlier_done_;  ///< when this process began to work
};

}  // namespace intaglio::cell
