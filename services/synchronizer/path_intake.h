#pragma once

// Takes the ordered points of one job from the sorter, under credit. Its reader has no
// limit, for a full one stops the receive thread of the whole process; instead the intake
// enforces the credit. It takes what has come in every turn, drops what is of no open
// job, and fails the job of a sorter that sends more than was granted.

#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "services/platform/bus/flow.h"

namespace intaglio::synchronizer {

class PathIntake {
 public:
  PathIntake(bus::Bus& bus, const std::string& instance);

  /// Opens the stream of this job and attempt; forgets what came of another one.
  Status Open(const std::string& job_uid, std::uint32_t attempt);
  /// Takes what has come. kFault when a batch is missing, its columns disagree, or it is
  /// beyond the window or the size of a batch: then the stream is closed, and what still
  /// comes of it is dropped.
  Status Poll();
  /// Takes what comes when none is wanted, be it the notice that a sorter has gone: left
  /// untaken it would wake the loop again and again.
  void Drop();
  /// Cancels the stream at the sorter.
  void Close();

  bool complete() const { return complete_; }
  std::uint64_t total_count() const { return total_count_; }
  /// In the order of engraving, glass frame, mm.
  const PointCloud& path() const { return path_; }
  /// The complete path, once; closes the stream.
  PointCloud TakePath();
  bus::Reader<intaglio_PathBatch>& reader() { return reader_; }

 private:
  Status Accept(const intaglio_PathBatch& batch);
  Status Check(const intaglio_PathBatch& batch) const;

  bus::Reader<intaglio_PathBatch> reader_;
  bus::CreditGrantor credit_;
  std::string job_uid_;
  std::uint32_t attempt_ = 0;
  std::string stream_;
  std::uint64_t expected_ = 0;
  std::uint64_t granted_ = 0;  ///< batches below this number may have been sent
  std::uint64_t total_count_ = 0;
  bool complete_ = false;
  PointCloud path_;
};

}  // namespace intaglio::synchronizer
