#include "services/host/cloud_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "services/bus/samples.h"

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
Status CloudIntake<Batch>::Open(const std::string& job_uid, std::uint32_t attempt) {
  Close();
  job_uid_ = job_uid;
  attempt_ = attempt;
  stream_ = bus::StreamName(job_uid, attempt, topic_name_);
  return credit_.Open(stream_, reader_.guid(), kWindowBatches);
}

template <typename Batch>
void CloudIntake<Batch>::Close() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
  expected_ = 0;
  complete_ = false;
  cloud_ = {};
}

template <typename Batch>
Result<bool> CloudIntake<Batch>::Poll() {
  Status status;
  reader_.Take([&](const Batch& batch) {
    if (stream_.empty() || complete_ || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    status = Accept(batch);
  });
  if (!status) return tl::unexpected(status.error());
  return complete_;
}

template <typename Batch>
Status CloudIntake<Batch>::Accept(const Batch& batch) {
  const auto x = bus::View(batch.x_mm), y = bus::View(batch.y_mm),
             z = bus::View(batch.z_mm);
  const auto source = bus::View(batch.source);
  if (batch.sequence_number != expected_ || batch.first_index != cloud_.size()) {
    return Fail(ErrorCode::kLinkLost,
                fmt::format("batch {} of {} is missing: hand the job out again",
                            expected_, topic_name_));
  }
  if (batch.total_count > kMaxCloudPoints) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a cloud of {} points is more than the {} allowed: take a "
                            "wider spacing",
                            batch.total_count, kMaxCloudPoints),
                std::to_string(batch.total_count));
  }
  const std::size_t size = cloud_.size() + x.size();
  if (y.size() != x.size() || z.size() != x.size() || source.size() != x.size() ||
      size > batch.total_count || (batch.last && size != batch.total_count)) {
    return Fail(ErrorCode::kFault,
                fmt::format("batch {} of {} contradicts itself: {} of {} points",
                            expected_, topic_name_, size, batch.total_count));
  }
  cloud_.points_mm.reserve(batch.total_count);
  cloud_.source.reserve(batch.total_count);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 p_mm(x[i], y[i], z[i]);
    if (!p_mm.allFinite()) {
      return Fail(ErrorCode::kFault,
                  fmt::format("point {} is not a finite number", cloud_.size()));
    }
    cloud_.Add(p_mm, source[i]);
  }
  ++expected_;
  complete_ = batch.last;
  return credit_.Consumed(stream_, expected_, complete_);
}

template <typename Batch>
CloudSender<Batch>::CloudSender(bus::Bus& bus, const bus::Topic<Batch>& topic)
    : topic_name_(topic.name), writer_(bus, topic), credit_(bus) {}

template <typename Batch>
void CloudSender<Batch>::Begin(const std::string& job_uid, std::uint32_t attempt,
                               PointCloud cloud,
                               std::chrono::steady_clock::time_point now) {
  job_uid_ = job_uid;
  attempt_ = attempt;
  stream_ = bus::StreamName(job_uid, attempt, topic_name_);
  cloud_ = std::move(cloud);
  sent_ = consumed_ = 0;
  moved_at_ = now;
}

template <typename Batch>
void CloudSender<Batch>::End() {
  stream_.clear();
  cloud_ = {};
}

// An empty cloud is one empty batch: the consumer has to hear of its end.
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
        fmt::format("the consumer of {} is gone or wants no more of it", stream_));
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
                fmt::format("nobody takes {}: see whether its consumer runs", stream_));
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
