#include "services/platform/host/stage/cloud_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {
// 7 MB in flight.
constexpr std::uint32_t kWindowBatches = 32;
}  // namespace

template <typename Batch>
CloudIntake<Batch>::CloudIntake(bus::Bus& bus, const std::string& instance,
                                const bus::Topic<Batch>& topic)
    : topic_name_(topic.name), reader_(bus, topic), credit_(bus, instance) {}

template <typename Batch>
std::string CloudIntake<Batch>::StreamOf(std::uint32_t part,
                                         std::uint32_t part_attempt) const {
  return bus::PartStreamName(job_uid_, attempt_, topic_name_, part, part_attempt);
}

template <typename Batch>
Status CloudIntake<Batch>::Open(const std::string& job_uid, std::uint32_t attempt,
                                std::uint32_t part_count) {
  Close();
  if (part_count == 0 || part_count > kMaxParts) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a cloud in {} parts; 1 to {} are allowed", part_count, kMaxParts));
  }
  job_uid_ = job_uid;
  attempt_ = attempt;
  parts_.resize(part_count);
  for (std::uint32_t part = 0; part < part_count; ++part) {
    for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again) {
      const auto opened =
          credit_.Open(StreamOf(part, again), reader_.guid(), kWindowBatches);
      if (!opened) return opened;
    }
  }
  return {};
}

template <typename Batch>
void CloudIntake<Batch>::Close() {
  for (std::uint32_t part = 0; part < parts_.size(); ++part) {
    for (std::uint32_t again = 0; again < kMaxPartAttempts; ++again) {
      (void)credit_.Close(StreamOf(part, again));
    }
  }
  parts_.clear();
}

template <typename Batch>
Result<bool> CloudIntake<Batch>::Poll() {
  Status status;
  reader_.Take([&](const Batch& batch) {
    if (parts_.empty() || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    status = Accept(batch);
  });
  if (!status) return tl::unexpected(status.error());
  if (parts_.empty()) return false;
  const bool whole = std::all_of(parts_.begin(), parts_.end(),
                                 [](const Part& part) { return part.whole; });
  if (!whole) credit_.Repeat(std::chrono::steady_clock::now());
  return whole;
}

template <typename Batch>
PointCloud CloudIntake<Batch>::TakeCloud() {
  PointCloud cloud = std::move(parts_.front().cloud);
  std::size_t size = cloud.size();
  for (std::size_t i = 1; i < parts_.size(); ++i) size += parts_[i].cloud.size();
  cloud.points_mm.reserve(size);
  cloud.source.reserve(size);
  for (std::size_t i = 1; i < parts_.size(); ++i) {
    const PointCloud part = std::exchange(parts_[i].cloud, {});
    cloud.points_mm.insert(cloud.points_mm.end(), part.points_mm.begin(),
                           part.points_mm.end());
    cloud.source.insert(cloud.source.end(), part.source.begin(), part.source.end());
  }
  return cloud;
}

template <typename Batch>
void CloudIntake<Batch>::BeginAgain(std::uint32_t part, std::uint32_t part_attempt) {
  for (std::uint32_t old = 0; old < part_attempt; ++old) {
    (void)credit_.Close(StreamOf(part, old));
  }
  parts_[part] = {};
  parts_[part].attempt = part_attempt;
}

template <typename Batch>
Status CloudIntake<Batch>::Check(const Batch& batch, const Part& part) const {
  if (batch.sequence_number != part.expected || batch.first_index != part.cloud.size()) {
    return Fail(ErrorCode::kLinkLost,
                fmt::format("batch {} of {}, part {} is missing: assign the task again",
                            part.expected, topic_name_, batch.part));
  }
  std::uint64_t others = 0;
  for (const Part& other : parts_) others += &other == &part ? 0 : other.total_count;
  if (batch.total_count > kMaxCloudPoints - std::min(others, kMaxCloudPoints)) {
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("a cloud of {} points exceeds the {} allowed: use a larger spacing",
                    others + batch.total_count, kMaxCloudPoints),
        std::to_string(batch.total_count));
  }
  const std::size_t count = batch.x_mm._length, size = part.cloud.size() + count;
  const bool other_total = part.expected > 0 && batch.total_count != part.total_count;
  if (batch.y_mm._length != count || batch.z_mm._length != count ||
      batch.source._length != count || size > batch.total_count || other_total ||
      (batch.last && size != batch.total_count)) {
    return Fail(
        ErrorCode::kFault,
        fmt::format("batch {} of {}, part {} contradicts itself: {} of {} points",
                    part.expected, topic_name_, batch.part, size, batch.total_count));
  }
  return {};
}

template <typename Batch>
Status CloudIntake<Batch>::Accept(const Batch& batch) {
  if (batch.part_count != parts_.size() ||
      !TaskPart{batch.part, batch.part_count, batch.part_attempt}.valid()) {
    return Fail(
        ErrorCode::kFault,
        fmt::format("part {}.{} of {} of {} does not belong to this cloud", batch.part,
                    batch.part_attempt, batch.part_count, topic_name_));
  }
  Part& part = parts_[batch.part];
  if (batch.part_attempt < part.attempt) return {};
  const std::string stream = StreamOf(batch.part, batch.part_attempt);
  if (part.whole) {
    return credit_.Consumed(stream, batch.sequence_number + 1, batch.last);
  }
  if (batch.part_attempt > part.attempt) BeginAgain(batch.part, batch.part_attempt);
  INTAGLIO_TRY(Check(batch, part));
  const auto x = bus::View(batch.x_mm), y = bus::View(batch.y_mm),
             z = bus::View(batch.z_mm);
  const auto source = bus::View(batch.source);
  part.total_count = batch.total_count;
  part.cloud.points_mm.reserve(batch.total_count);
  part.cloud.source.reserve(batch.total_count);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 p_mm(x[i], y[i], z[i]);
    if (!p_mm.allFinite()) {
      return Fail(ErrorCode::kFault,
                  fmt::format("point {} is not a finite number", part.cloud.size()));
    }
    part.cloud.Add(p_mm, source[i]);
  }
  ++part.expected;
  part.whole = batch.last;
  return credit_.Consumed(stream, part.expected, part.whole);
}

template <typename Batch>
CloudSender<Batch>::CloudSender(bus::Bus& bus, const bus::Topic<Batch>& topic,
                                const std::string& consumers)
    : topic_name_(topic.name), writer_(bus, topic), credit_(bus, consumers) {}

template <typename Batch>
void CloudSender<Batch>::Begin(const std::string& job_uid, std::uint32_t attempt,
                               TaskPart part, PointCloud cloud,
                               std::chrono::steady_clock::time_point now) {
  job_uid_ = job_uid;
  attempt_ = attempt;
  part_ = part;
  stream_ = bus::PartStreamName(job_uid, attempt, topic_name_, part.index, part.attempt);
  cloud_ = std::move(cloud);
  sent_ = consumed_ = 0;
  moved_at_ = now;
}

template <typename Batch>
void CloudSender<Batch>::End() {
  stream_.clear();
  cloud_ = {};
}

// An empty cloud is one empty batch: the consumer has to receive its end.
template <typename Batch>
std::uint64_t CloudSender<Batch>::batch_count() const {
  return std::max<std::uint64_t>(1, (cloud_.size() + kBatchPoints - 1) / kBatchPoints);
}

template <typename Batch>
Result<bool> CloudSender<Batch>::Advance(std::chrono::steady_clock::time_point now) {
  credit_.Poll();
  if (stream_.empty()) return true;
  const auto grant = credit_.Find(stream_);
  const bool all_sent = sent_ == batch_count();
  // What it does after it has everything is not this stage's concern.
  if (all_sent && (grant.consumed == sent_ || grant.cancelled)) return true;
  if (grant.cancelled) {
    return Fail(
        ErrorCode::kLinkLost,
        fmt::format("the consumer of {} has ended or accepts no more of it", stream_));
  }
  if (grant.consumed != consumed_) moved_at_ = now;
  consumed_ = grant.consumed;
  if (grant.open && (sent_ > 0 || writer_.IsMatched(grant.reader))) {
    while (sent_ < std::min(grant.limit, batch_count())) {
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

template <typename Batch>
Status CloudSender<Batch>::SendNext() {
  const std::size_t first = sent_ * kBatchPoints;
  const std::size_t count = std::min(kBatchPoints, cloud_.size() - first);
  std::vector<double> x(count), y(count), z(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& p_mm = cloud_.points_mm[first + i];
    x[i] = p_mm.x(), y[i] = p_mm.y(), z[i] = p_mm.z();
  }
  const auto begin = cloud_.source.begin() + static_cast<std::ptrdiff_t>(first);
  const std::vector<std::uint32_t> source(begin,
                                          begin + static_cast<std::ptrdiff_t>(count));
  Batch batch{};
  batch.job_uid = bus::Borrow(job_uid_);
  batch.attempt = attempt_;
  batch.part = part_.index;
  batch.part_count = part_.count;
  batch.part_attempt = part_.attempt;
  batch.sequence_number = sent_;
  batch.first_index = first;
  batch.total_count = cloud_.size();
  batch.last = sent_ + 1 == batch_count();
  bus::Borrow(batch.x_mm, x);
  bus::Borrow(batch.y_mm, y);
  bus::Borrow(batch.z_mm, z);
  bus::Borrow(batch.source, source);
  auto written = writer_.Write(batch);
  if (written) ++sent_;
  return written;
}

template class CloudIntake<intaglio_PointBatch>;
template class CloudSender<intaglio_PointBatch>;
template class CloudSender<intaglio_PathBatch>;

}  // namespace intaglio::host
