#include "services/platform/host/stage/mark_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {
// 6 MB in flight.
constexpr std::uint32_t kMarkWindow = 32;
}  // namespace

MarkIntake::MarkIntake(bus::Bus& bus, const std::string& instance,
                       const bus::Topic<intaglio_MarkBatch>& topic)
    : topic_name_(topic.name), reader_(bus, topic), credit_(bus, instance) {}

std::string MarkIntake::StreamOf(std::uint32_t part_attempt) const {
  return bus::PartStreamName(job_uid_, attempt_, topic_name_, 0, part_attempt);
}

Status MarkIntake::Open(const std::string& job_uid, std::uint32_t attempt) {
  Close();
  job_uid_ = job_uid;
  attempt_ = attempt;
  open_ = true;
  BeginAgain(0);
  for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again)
    INTAGLIO_TRY(credit_.Open(StreamOf(again), reader_.guid(), kMarkWindow));
  return {};
}

void MarkIntake::BeginAgain(std::uint32_t part_attempt) {
  for (std::uint32_t old = 0; old < part_attempt; ++old)
    (void)credit_.Close(StreamOf(old));
  part_attempt_ = part_attempt;
  complete_ = false;
  expected_ = total_count_ = place_count_ = 0;
  granted_ = kMarkWindow;
  marks_ = {};
}

void MarkIntake::Close() {
  if (!open_) return;
  for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again)
    (void)credit_.Close(StreamOf(again));
  open_ = false;
}

// What has come was sent under the credit of earlier turns: more is granted afterwards.
Result<bool> MarkIntake::Poll() {
  Status status;
  const auto before = std::pair(part_attempt_, expected_);
  reader_.Take([&](const intaglio_MarkBatch& batch) {
    if (!open_ || complete_ || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    if (batch.part_attempt < part_attempt_ || batch.part_attempt >= kMaxPartAttempts)
      return;
    if (batch.part_attempt > part_attempt_) BeginAgain(batch.part_attempt);
    status = Accept(batch);
  });
  if (!status) {
    Close();
    return tl::unexpected(status.error());
  }
  if (!open_) return false;
  if (std::pair(part_attempt_, expected_) != before) {
    granted_ = expected_ + kMarkWindow;
    INTAGLIO_TRY(credit_.Consumed(StreamOf(part_attempt_), expected_, complete_));
  }
  if (!complete_) credit_.Repeat(std::chrono::steady_clock::now());
  return complete_;
}

Status MarkIntake::Check(const intaglio_MarkBatch& batch) const {
  const std::uint64_t number = batch.sequence_number;
  if (number != expected_ || batch.first_mark != marks_.marks.size()) {
    return Fail(ErrorCode::kLinkLost,
                fmt::format("batch {} of {} is missing: assign the task again", expected_,
                            topic_name_));
  }
  if (number >= granted_) {
    return Fail(
        ErrorCode::kFault,
        fmt::format("batch {} of {} exceeds the granted credit, batches below {}: "
                    "the sender is faulty; restart it and submit the job again",
                    number, topic_name_, granted_));
  }
  return CheckCounts(batch);
}

Status MarkIntake::CheckCounts(const intaglio_MarkBatch& batch) const {
  const std::uint64_t total = batch.total_count;
  const std::uint64_t count = marks_.marks.size() + batch.pen._length;
  const std::uint64_t places = place_count_ + batch.x_mm._length;
  std::string what;
  if (total > kMaxMarks) {
    what = fmt::format("total_count is {}, above {}", total, kMaxMarks);
  } else if (batch.sequence_number > 0 && total != total_count_) {
    what = fmt::format("total_count is {}, and was {}", total, total_count_);
  } else if (count > total) {
    what = fmt::format("total_count is {}, and {} marks have come", total, count);
  } else if (batch.last && count != total) {
    what = fmt::format("it is the last, with {} of {} marks", count, total);
  } else if (places > kMaxPlaces) {
    what = fmt::format("{} places have come, above {}", places, kMaxPlaces);
  } else if (batch.pen._length == 0 && !batch.last) {
    what = "it has no marks and is not the last";
  } else {
    return {};
  }
  return Fail(ErrorCode::kFault,
              fmt::format("batch {} of {}: {}: the sender is faulty; restart it and "
                          "submit the job again",
                          batch.sequence_number, topic_name_, what));
}

Status MarkIntake::Accept(const intaglio_MarkBatch& batch) {
  INTAGLIO_TRY(Check(batch));
  INTAGLIO_TRY(AppendMarks(batch, marks_));
  ++expected_;
  total_count_ = batch.total_count;
  place_count_ += batch.x_mm._length;
  complete_ = batch.last;
  return {};
}

mark::MarkSet MarkIntake::TakeMarks() {
  Close();
  complete_ = false;
  return std::exchange(marks_, {});
}

MarkSender::MarkSender(bus::Bus& bus, const bus::Topic<intaglio_MarkBatch>& topic,
                       const std::string& consumers)
    : topic_name_(topic.name), writer_(bus, topic), credit_(bus, consumers) {}

void MarkSender::Begin(const std::string& job_uid, std::uint32_t attempt,
                       std::uint32_t part_attempt, mark::MarkSet marks,
                       std::chrono::steady_clock::time_point now) {
  job_uid_ = job_uid;
  attempt_ = attempt;
  part_attempt_ = part_attempt;
  stream_ = bus::PartStreamName(job_uid, attempt, topic_name_, 0, part_attempt);
  marks_ = std::move(marks);
  next_mark_ = 0;
  all_sent_ = false;
  sent_ = consumed_ = 0;
  moved_at_ = now;
}

void MarkSender::End() {
  stream_.clear();
  marks_ = {};
}

Result<bool> MarkSender::Advance(std::chrono::steady_clock::time_point now) {
  credit_.Poll();
  if (stream_.empty()) return true;
  const auto grant = credit_.Find(stream_);
  // What it does after it has everything is not this stage's concern.
  if (all_sent_ && (grant.consumed == sent_ || grant.cancelled)) return true;
  if (grant.cancelled) {
    return Fail(
        ErrorCode::kLinkLost,
        fmt::format("the consumer of {} has ended or accepts no more of it", stream_));
  }
  if (grant.consumed != consumed_) moved_at_ = now;
  consumed_ = grant.consumed;
  if (grant.open && (sent_ > 0 || writer_.IsMatched(grant.reader))) {
    while (!all_sent_ && sent_ < grant.limit) {
      const auto sent = SendNext();
      if (!sent && sent.error().code == ErrorCode::kTimedOut) break;
      if (!sent) return tl::unexpected(sent.error());
      moved_at_ = now;
    }
  }
  if (now - moved_at_ > kPatience) {
    return Fail(ErrorCode::kTimedOut,
                fmt::format("{} has no consumer: check that its consumer runs", stream_));
  }
  return false;
}

Status MarkSender::SendNext() {
  const std::size_t count = BatchSizeAt(marks_, next_mark_);
  const MarkColumns columns(marks_, next_mark_, count);
  intaglio_MarkBatch batch{};
  batch.job_uid = bus::Borrow(job_uid_);
  batch.attempt = attempt_;
  batch.part_attempt = part_attempt_;
  batch.sequence_number = sent_;
  batch.first_mark = next_mark_;
  batch.total_count = marks_.marks.size();
  batch.last = next_mark_ + count == marks_.marks.size();
  columns.BorrowTo(batch);
  INTAGLIO_TRY(writer_.Write(batch));
  ++sent_;
  next_mark_ += count;
  all_sent_ = batch.last;
  return {};
}

}  // namespace intaglio::host
