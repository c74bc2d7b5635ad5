#include "services/platform/host/stage/flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {

template <typename Codec>
Intake<Codec>::Intake(bus::Bus& bus, const std::string& instance,
                      const bus::Topic<Batch>& topic)
    : topic_name_(topic.name), reader_(bus, topic), credit_(bus, instance) {}

template <typename Codec>
std::string Intake<Codec>::StreamOf(std::uint32_t part,
                                    std::uint32_t part_attempt) const {
  return bus::PartStreamName(job_uid_, attempt_, topic_name_, part, part_attempt);
}

template <typename Codec>
std::string Intake<Codec>::NameOf(std::uint64_t number, std::uint32_t part) const {
  const std::string name = fmt::format("batch {} of {}", number, topic_name_);
  return parts_.size() == 1 ? name : fmt::format("{}, part {}", name, part);
}

template <typename Codec>
Status Intake<Codec>::Open(const std::string& job_uid, std::uint32_t attempt,
                           std::uint32_t part_count) {
  Close();
  if (part_count == 0 || part_count > kMaxParts) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} parts of {}; 1 to {} are allowed", part_count,
                            Codec::kItems, kMaxParts));
  }
  job_uid_ = job_uid;
  attempt_ = attempt;
  taken_ = false;
  parts_.resize(part_count);
  for (std::uint32_t part = 0; part < part_count; ++part) {
    for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again) {
      INTAGLIO_TRY(
          credit_.Open(StreamOf(part, again), reader_.guid(), Codec::kWindowBatches));
    }
  }
  return {};
}

template <typename Codec>
void Intake<Codec>::Close() {
  for (std::uint32_t part = 0; part < parts_.size(); ++part) {
    for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again)
      (void)credit_.Close(StreamOf(part, again));
  }
  parts_.clear();
}

// What has come was sent under the credit of earlier turns: more is granted afterwards.
template <typename Codec>
Result<bool> Intake<Codec>::Poll() {
  Status status;
  reader_.Take([&](const Batch& batch) {
    if (parts_.empty() || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    status = Accept(batch);
  });
  if (status) status = GrantMore();
  if (!status) {
    Close();
    return tl::unexpected(status.error());
  }
  if (parts_.empty()) return false;
  const bool whole = std::all_of(parts_.begin(), parts_.end(),
                                 [](const Part& part) { return part.whole; });
  if (!whole) credit_.Repeat(std::chrono::steady_clock::now());
  return whole && !taken_;
}

template <typename Codec>
Status Intake<Codec>::GrantMore() {
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    if (part.expected == part.reported) continue;
    part.reported = part.expected;
    INTAGLIO_TRY(credit_.Consumed(StreamOf(i, part.attempt), part.expected, part.whole));
  }
  return {};
}

template <typename Codec>
typename Codec::Content Intake<Codec>::TakeContent() {
  std::vector<typename Codec::Content> contents;
  for (Part& part : parts_) {
    contents.push_back(std::move(part.received.content));
    part.received = {};
  }
  taken_ = true;
  return Codec::Join(std::move(contents));
}

template <typename Codec>
void Intake<Codec>::BeginAgain(const TaskPart& which) {
  for (std::uint32_t old = 0; old < which.attempt; ++old)
    (void)credit_.Close(StreamOf(which.index, old));
  parts_[which.index] = {};
  parts_[which.index].attempt = which.attempt;
}

template <typename Codec>
Status Intake<Codec>::Accept(const Batch& batch) {
  const TaskPart which = Codec::PartOf(batch);
  if (which.count != parts_.size() || !which.valid()) {
    return Fail(ErrorCode::kFault,
                fmt::format("part {}.{} of {} of {} does not belong "
                            "to what was asked for, {}",
                            which.index, which.attempt, which.count, topic_name_,
                            Counted(parts_.size(), "part")));
  }
  Part& part = parts_[which.index];
  if (which.attempt < part.attempt) return {};
  if (part.whole) {
    return credit_.Consumed(StreamOf(which.index, which.attempt),
                            batch.sequence_number + 1, batch.last);
  }
  if (which.attempt > part.attempt) BeginAgain(which);
  return AcceptPart(batch, which);
}

template <typename Codec>
Status Intake<Codec>::AcceptPart(const Batch& batch, const TaskPart& which) {
  INTAGLIO_TRY(Check(batch, which));
  Part& part = parts_[which.index];
  INTAGLIO_TRY(part.received.Append(batch));
  part.total_count = batch.total_count;
  part.whole = batch.last;
  ++part.expected;
  return {};
}

template <typename Codec>
Status Intake<Codec>::Check(const Batch& batch, const TaskPart& which) const {
  const Part& part = parts_[which.index];
  if (batch.sequence_number != part.expected ||
      Codec::FirstOf(batch) != part.received.size()) {
    return Fail(ErrorCode::kLinkLost, fmt::format("{} is missing: assign the task again",
                                                  NameOf(part.expected, which.index)));
  }
  INTAGLIO_TRY(
      credit_.CheckGranted(StreamOf(which.index, which.attempt), batch.sequence_number));
  std::uint64_t others = 0;
  for (const Part& other : parts_) others += &other == &part ? 0 : other.total_count;
  INTAGLIO_TRY(Codec::CheckTotal(batch, others));
  return CheckCounts(batch, part);
}

template <typename Codec>
Status Intake<Codec>::CheckCounts(const Batch& batch, const Part& part) const {
  const std::uint64_t total = batch.total_count;
  const std::uint64_t count = part.received.size() + Codec::CountOf(batch);
  std::string what;
  if (part.expected > 0 && total != part.total_count) {
    what = fmt::format("total_count is {}, and was {}", total, part.total_count);
  } else if (count > total) {
    what = fmt::format("total_count is {}, and {} {} have come", total, count,
                       Codec::kItems);
  } else if (batch.last && count != total) {
    what = fmt::format("it is the last, with {} of {} {}", count, total, Codec::kItems);
  } else if (Codec::CountOf(batch) == 0 && !batch.last) {
    what = fmt::format("it has no {} and is not the last", Codec::kItems);
  } else {
    return {};
  }
  return Fail(
      ErrorCode::kFault,
      fmt::format("{}: {}: the sender is faulty; restart it and submit the job "
                  "again",
                  NameOf(batch.sequence_number, Codec::PartOf(batch).index), what));
}

template <typename Codec>
Sender<Codec>::Sender(bus::Bus& bus, const bus::Topic<Batch>& topic,
                      const std::string& consumers)
    : topic_name_(topic.name), writer_(bus, topic), credit_(bus, consumers) {}

template <typename Codec>
void Sender<Codec>::Begin(const std::string& job_uid, std::uint32_t attempt,
                          TaskPart part, typename Codec::Content content,
                          std::chrono::steady_clock::time_point now) {
  job_uid_ = job_uid;
  attempt_ = attempt;
  part_ = part;
  stream_ = bus::PartStreamName(job_uid, attempt, topic_name_, part.index, part.attempt);
  content_ = std::move(content);
  next_item_ = 0;
  all_sent_ = false;
  sent_ = consumed_ = 0;
  moved_at_ = now;
}

template <typename Codec>
void Sender<Codec>::End() {
  stream_.clear();
  content_ = {};
}

template <typename Codec>
Result<bool> Sender<Codec>::Advance(std::chrono::steady_clock::time_point now) {
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

template <typename Codec>
Status Sender<Codec>::SendNext() {
  const std::size_t count = Codec::CountAt(content_, next_item_);
  const typename Codec::Columns columns(content_, next_item_, count);
  Batch batch{};
  batch.job_uid = bus::Borrow(job_uid_);
  batch.attempt = attempt_;
  batch.part_attempt = part_.attempt;
  batch.sequence_number = sent_;
  batch.total_count = Codec::SizeOf(content_);
  batch.last = next_item_ + count == batch.total_count;
  Codec::SetPlace(batch, part_, next_item_);
  columns.BorrowTo(batch);
  INTAGLIO_TRY(writer_.Write(batch));
  ++sent_;
  next_item_ += count;
  all_sent_ = batch.last;
  return {};
}

template class Intake<PointCodec<intaglio_PointBatch>>;
template class Sender<PointCodec<intaglio_PointBatch>>;
template class Intake<PointCodec<intaglio_PathBatch>>;
template class Sender<PointCodec<intaglio_PathBatch>>;
template class Intake<MarkCodec>;
template class Sender<MarkCodec>;

}  // namespace intaglio::host
