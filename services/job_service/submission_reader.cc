#include "services/job_service/submission_reader.h"

#include <fmt/format.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

/// An exception may not end the process from a thread of its own.
Result<FrozenJob> ReadGuarded(const SubmissionReader::Read& read,
                              const std::vector<std::uint8_t>& job) {
  try {
    return read(job);
  } catch (const std::exception& error) {
    return Fail(ErrorCode::kFault,
                fmt::format("the job service cannot read it: {}; submit it again, or in "
                            "parts",
                            error.what()));
  }
}

}  // namespace

struct SubmissionReader::Reading {
  std::mutex mutex;
  std::condition_variable ended;
  std::optional<Result<FrozenJob>> result;

  std::optional<Result<FrozenJob>> Take() {
    const std::lock_guard lock(mutex);
    return std::exchange(result, std::nullopt);
  }
  bool is_there() {
    const std::lock_guard lock(mutex);
    return result.has_value();
  }
};

SubmissionReader::~SubmissionReader() {
  if (!reading_) return;
  std::unique_lock lock(reading_->mutex);
  reading_->ended.wait_for(lock, 1s, [this] { return reading_->result.has_value(); });
}

bool SubmissionReader::Add(Submission submission, Nanoseconds now) {
  if (known_.contains(submission.uid)) return true;
  const auto waiting = waiting_.find(submission.process);
  if (waiting != waiting_.end() && waiting->second.size() >= kMaxOfProcess) return false;
  known_.insert(submission.uid);
  waiting_[submission.process].push_back(std::move(submission));
  if (!reading_) Start(now);
  return true;
}

// The oldest one of the process behind the one that was served last.
SubmissionReader::Submission SubmissionReader::TakeNext() {
  auto turn = waiting_.upper_bound(current_.process);
  if (turn == waiting_.end()) turn = waiting_.begin();
  Submission next = std::move(turn->second.front());
  turn->second.pop_front();
  if (turn->second.empty()) waiting_.erase(turn);
  return next;
}

void SubmissionReader::Start(Nanoseconds now) {
  if (waiting_.empty()) return;
  current_ = TakeNext();
  since_ = now;
  reading_ = std::make_shared<Reading>();
  if (CountHanging() >= kMaxHanging) {
    reading_->result =
        Fail(ErrorCode::kTimedOut,
             fmt::format(
                 "the job service still waits for the files of {} earlier submissions, "
                 "and reads no more: restore their network mounts, or restart it",
                 kMaxHanging));
    return;
  }
  try {
    std::thread([reading = reading_, read = read_, job = std::move(current_.job)] {
      auto result = ReadGuarded(read, job);
      const std::lock_guard lock(reading->mutex);
      reading->result = std::move(result);
      reading->ended.notify_all();
    }).detach();
  } catch (const std::system_error& error) {
    reading_->result = Fail(
        ErrorCode::kIo, fmt::format("the job service cannot start a thread to read it: "
                                    "{}; raise its limits, or submit again later",
                                    error.what()));
  }
}

std::size_t SubmissionReader::CountHanging() {
  std::erase_if(hanging_, [](const auto& reading) { return reading->is_there(); });
  return hanging_.size();
}

std::vector<SubmissionReader::Answer> SubmissionReader::Take(Nanoseconds now) {
  std::vector<Answer> answers;
  while (reading_) {
    auto result = reading_->Take();
    if (!result && now - since_ < kReadWithin) break;
    if (!result) {
      hanging_.push_back(reading_);
      result = Fail(ErrorCode::kTimedOut,
                    fmt::format("machine_file, models: cannot be read within {} s on the "
                                "job service's host: check its disks and network mounts",
                                kReadWithin.count()));
    }
    known_.erase(current_.uid);
    answers.push_back({current_.uid, current_.client, std::move(*result)});
    reading_.reset();
    Start(now);
  }
  return answers;
}

}  // namespace intaglio::job_service
