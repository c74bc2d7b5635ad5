#include "services/synchronizer/path_intake.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/cloud_flow.h"

namespace intaglio::synchronizer {
namespace {
constexpr std::uint32_t kWindowBatches = 32;
}  // namespace

PathIntake::PathIntake(bus::Bus& bus, const std::string& instance)
    : reader_(bus, bus::kPathBatch), credit_(bus, instance) {}

Status PathIntake::Open(const std::string& job_uid, std::uint32_t attempt) {
  Close();
  job_uid_ = job_uid;
  attempt_ = attempt;
  stream_ = bus::PartStreamName(job_uid, attempt, bus::kPathBatch.name, 0, 0);
  expected_ = total_count_ = 0;
  granted_ = kWindowBatches;
  complete_ = false;
  path_ = {};
  return credit_.Open(stream_, reader_.guid(), kWindowBatches);
}

void PathIntake::Close() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
}

// What has come was sent under the credit of earlier turns: more is granted afterwards.
Status PathIntake::Poll() {
  Status status;
  const std::uint64_t expected_before = expected_;
  reader_.Take([&](const intaglio_PathBatch& batch) {
    if (stream_.empty() || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    status = Accept(batch);
  });
  if (!status) {
    Close();
    return status;
  }
  if (expected_ == expected_before) return {};
  granted_ = expected_ + kWindowBatches;
  return credit_.Consumed(stream_, expected_, complete_);
}

void PathIntake::Drop() {
  reader_.Take([](const intaglio_PathBatch&) {});
}

Status PathIntake::Check(const intaglio_PathBatch& batch) const {
  const std::size_t count = bus::View(batch.x_mm).size();
  if (batch.sequence_number != expected_ || batch.first_index != path_.size()) {
    return Fail(ErrorCode::kFault,
                fmt::format("path batch {} is missing: the task has to be assigned again",
                            expected_));
  }
  if (batch.sequence_number >= granted_ || count > host::kBatchPoints) {
    return Fail(
        ErrorCode::kFault,
        fmt::format("path batch {} with {} points exceeds the granted credit, batches "
                    "below {} with up to {} points: the sorter has another version or is "
                    "faulty; restart it and submit the job again",
                    batch.sequence_number, count, granted_, host::kBatchPoints));
  }
  const bool agrees = bus::View(batch.y_mm).size() == count &&
                      bus::View(batch.z_mm).size() == count &&
                      bus::View(batch.source).size() == count &&
                      (expected_ == 0 || batch.total_count == total_count_);
  if (!agrees || batch.total_count > host::kMaxCloudPoints ||
      path_.size() + count > batch.total_count) {
    return Fail(ErrorCode::kFault,
                fmt::format("path batch {} contradicts itself: {} of {} points",
                            expected_, path_.size() + count, batch.total_count));
  }
  return {};
}

Status PathIntake::Accept(const intaglio_PathBatch& batch) {
  INTAGLIO_TRY(Check(batch));
  const auto x = bus::View(batch.x_mm), y = bus::View(batch.y_mm),
             z = bus::View(batch.z_mm);
  const auto source = bus::View(batch.source);
  path_.points_mm.reserve(batch.total_count);
  path_.source.reserve(batch.total_count);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 p(x[i], y[i], z[i]);
    if (!p.allFinite()) {
      return Fail(ErrorCode::kFault,
                  fmt::format("point {} of the path is not a number", path_.size()));
    }
    path_.Add(p, source[i]);
  }
  ++expected_;
  total_count_ = batch.total_count;
  complete_ = batch.last;
  if (complete_ && path_.size() != total_count_) {
    return Fail(ErrorCode::kFault, fmt::format("the path ends after {} of {} points",
                                               path_.size(), total_count_));
  }
  return {};
}

PointCloud PathIntake::TakePath() {
  Close();
  complete_ = false;
  return std::exchange(path_, {});
}

}  // namespace intaglio::synchronizer
