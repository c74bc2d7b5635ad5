#pragma once

// Reads and checks submissions beside the job service's loop. A submission names files
// (its machine file, its models), and a dead network mount never answers: the loop, on
// which every machine's permission depends, never waits for them.
//
// One submission after another is read, each in a thread of its own. One that takes
// longer than kReadWithin is refused; its thread is left behind and ends when the mount
// answers. At most kMaxHanging threads are left behind: while so many hang, what comes is
// refused at once.
//
// The processes that submit have their turns one after the other, so that one that floods
// the topic delays itself: of each at most kMaxOfProcess submissions wait. Used from one
// thread.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/task.pb.h"

namespace intaglio::job_service {

class SubmissionReader {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// Long for a disk that wakes up, and shorter than a client waits (15 s).
  static constexpr std::chrono::seconds kReadWithin{5};
  static constexpr std::size_t kMaxHanging = 4;
  static constexpr std::size_t kMaxOfProcess = 4096;

  /// From the bytes of the job to the frozen job. Called from other threads, several at
  /// once when some hang, and maybe after the end of this object.
  using Read = std::function<Result<FrozenJob>(const std::vector<std::uint8_t>& job)>;
  explicit SubmissionReader(Read read) : read_(std::move(read)) {}
  /// Waits for the reading at work, for a second at most.
  ~SubmissionReader();

  struct Submission {
    std::string uid, client;
    std::vector<std::uint8_t> job;
    std::string process = {};  ///< that wrote it, as Bus::participant_name()
  };
  /// One that is being read or waits for it already is ignored. False: too many of its
  /// process wait, and it is dropped.
  bool Add(Submission submission, Nanoseconds now);

  struct Answer {
    std::string uid, client;
    Result<FrozenJob> frozen;
  };
  /// What was read since the last call, in the order of Add. Never waits.
  std::vector<Answer> Take(Nanoseconds now);

 private:
  struct Reading;  // shared with its thread
  void Start(Nanoseconds now);
  Submission TakeNext();
  std::size_t CountHanging();

  Read read_;
  std::map<std::string, std::deque<Submission>> waiting_;  // by process; none is empty
  std::set<std::string> known_;  // uids of those, and of the one that is read
  Submission current_;
  std::shared_ptr<Reading> reading_;  // null: none
  Nanoseconds since_{0};
  std::vector<std::shared_ptr<Reading>> hanging_;
};

}  // namespace intaglio::job_service
