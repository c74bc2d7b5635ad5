#pragma once

// The prepared models of a job, kept from one part of the job to the next: a discretizer
// that takes several parts reads and places the models once. Job is a pointer, empty
// while nothing is made. Used from one thread; the slot belongs to the computation while
// there is one.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace intaglio::discretizer {

template <typename Job>
class KeptJob {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// After its last part; the next one follows within milliseconds, if there is one.
  static constexpr std::chrono::seconds kKeptFor{10};

  /// A task begins: another job or attempt is dropped.
  void Begin(const std::string& job_uid, std::uint32_t attempt) {
    if (slot_ == nullptr || job_uid != job_uid_ || attempt != attempt_) {
      slot_ = std::make_shared<Job>();
    }
    job_uid_ = job_uid;
    attempt_ = attempt;
    at_work_ = true;
  }
  /// Where the job is, or is to be put by the computation.
  std::shared_ptr<Job> slot() const { return slot_; }
  bool holds_job() const { return slot_ != nullptr && *slot_ != nullptr; }

  /// The task has ended, and with it its computation.
  void End(bool withdrawn, TimePoint now) {
    at_work_ = false;
    ended_at_ = now;
    if (withdrawn) slot_.reset();
  }
  void DropWhenOld(TimePoint now) {
    if (!at_work_ && now - ended_at_ >= kKeptFor) slot_.reset();
  }

 private:
  std::string job_uid_;
  std::uint32_t attempt_ = 0;
  std::shared_ptr<Job> slot_;
  bool at_work_ = false;
  TimePoint ended_at_{};
};

}  // namespace intaglio::discretizer
