#include "services/synchronizer/path_intake.h"

#include <fmt/format.h>

#include <cmath>

#include "services/bus/samples.h"

namespace intaglio::synchronizer {
namespace {
constexpr std::uint32_t kWindowBatches = 32;
// The published machine holds 2 million points; a wild number may not take all memory.
constexpr std::uint64_t kMaxPoints = 20'000'000;
}  // namespace

PathIntake::PathIntake(bus::Bus& bus, const std::string& instance)
    : reader_(bus, bus::kPathBatch), credit_(bus, instance) {}

Status PathIntake::Open(const std::string& job_uid, std::uint32_t attempt) {
  Close();
  job_uid_ = job_uid;
  attempt_ = attempt;
  stream_ = bus::PartStreamName(job_uid, attempt, bus::kPathBatch.name, 0, 0);
  expected_ = total_count_ = 0;
  complete_ = false;
  path_ = {};
  return credit_.Open(stream_, reader_.guid(), kWindowBatches);
}

void PathIntake::Close() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
}

Status PathIntake::Poll() {
  Status status;
  reader_.Take([&](const intaglio_PathBatch& batch) {
    if (stream_.empty() || !status) return;
    if (bus::View(batch.job_uid) != job_uid_ || batch.attempt != attempt_) return;
    status = Accept(batch);
  });
  return status;
}

void PathIntake::Drop() {
  reader_.Take([](const intaglio_PathBatch&) {});
}

Status PathIntake::Accept(const intaglio_PathBatch& batch) {
  const auto x = bus::View(batch.x_mm), y = bus::View(batch.y_mm),
             z = bus::View(batch.z_mm);
  const auto source = bus::View(batch.source);
  if (batch.sequence_number != expected_ || batch.first_index != path_.size()) {
    return Fail(
        ErrorCode::kFault,
        fmt::format("path batch {} is missing: the job has to be handed out again",
                    expected_));
  }
  if (y.size() != x.size() || z.size() != x.size() || source.size() != x.size() ||
      batch.total_count > kMaxPoints || path_.size() + x.size() > batch.total_count) {
    return Fail(ErrorCode::kFault,
                fmt::format("path batch {} contradicts itself: {} of {} points",
                            expected_, path_.size() + x.size(), batch.total_count));
  }
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
  return credit_.Consumed(stream_, expected_, complete_);
}

}  // namespace intaglio::synchronizer
