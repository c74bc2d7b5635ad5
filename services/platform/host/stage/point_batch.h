#pragma once

// Points of a cloud or of a path as batches on the bus and back: the codec (flow.h) that
// knows the arrays of idl/cloud.idl PointBatch and PathBatch, which have the same
// members. Nothing of a batch is taken over unchecked.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "idl/cloud.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// 229 kB a batch: large enough for the network, small enough to spread the work.
inline constexpr std::size_t kBatchPoints = 8192;

/// The published machine engraves 2 million points; ten times that is 560 MB.
inline constexpr std::uint64_t kMaxCloudPoints = 20'000'000;

template <typename BatchType>
struct PointCodec {
  using Batch = BatchType;
  using Content = PointCloud;
  static constexpr std::uint32_t kWindowBatches = 32;  // 7 MB in flight
  static constexpr const char* kItems = "points";

  class Receiver {
   public:
    std::size_t size() const { return content.size(); }
    /// kFault: arrays that disagree, more than kBatchPoints, a coordinate that is not
    /// finite.
    Status Append(const Batch& batch);
    PointCloud content;
  };
  /// The arrays of one batch, which borrows them while it is written.
  class Columns {
   public:
    Columns(const PointCloud& cloud, std::size_t first, std::size_t count);
    void BorrowTo(Batch& batch) const;

   private:
    std::vector<double> x_mm_, y_mm_, z_mm_;
    std::vector<std::uint32_t> source_;
  };

  static TaskPart PartOf(const Batch& batch) {
    return {batch.part, batch.part_count, batch.part_attempt};
  }
  static std::uint64_t FirstOf(const Batch& batch) { return batch.first_index; }
  static std::size_t CountOf(const Batch& batch) { return batch.x_mm._length; }
  static std::size_t SizeOf(const PointCloud& cloud) { return cloud.size(); }
  /// kTooLarge: more than kMaxCloudPoints together.
  static Status CheckTotal(const Batch& batch, std::uint64_t others);
  static PointCloud Join(std::vector<PointCloud> parts);
  static std::size_t CountAt(const PointCloud& cloud, std::size_t first) {
    return std::min(kBatchPoints, cloud.size() - first);
  }
  static void SetPlace(Batch& batch, const TaskPart& part, std::size_t first) {
    batch.part = part.index;
    batch.part_count = part.count;
    batch.first_index = first;
  }
};

extern template struct PointCodec<intaglio_PointBatch>;
extern template struct PointCodec<intaglio_PathBatch>;

}  // namespace intaglio::host
