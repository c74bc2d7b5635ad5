#pragma once

// Marks (engrave/mark) as batches on the bus and back: the codec (flow.h) that knows the
// arrays of idl/cloud.idl MarkBatch. Nothing of a batch is taken over unchecked.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "idl/cloud.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// 200 kB of places a batch.
inline constexpr std::size_t kBatchPlaces = 8192;
inline constexpr std::size_t kBatchMarks = 4096;
/// Of one mark, which travels whole: 2.4 MB.
inline constexpr std::size_t kMaxMarkPlaces = 100'000;
/// Of a job: 480 MB of places.
inline constexpr std::uint64_t kMaxMarks = 5'000'000;
inline constexpr std::uint64_t kMaxPlaces = 20'000'000;
inline constexpr std::size_t kMaxPens = 1024;

/// The arrays of one batch, which borrows them while it is written.
class MarkColumns {
 public:
  /// Marks `first` .. `first + count - 1`, with the pens when `first` is 0.
  MarkColumns(const mark::MarkSet& set, std::size_t first, std::size_t count);
  void BorrowTo(intaglio_MarkBatch& batch) const;

 private:
  std::vector<intaglio_MarkPen> pens_;  // their names are the set's
  std::vector<std::uint32_t> pen_, place_count_;
  std::vector<std::uint8_t> closed_, dark_;
  std::vector<double> web_mm_, x_mm_, y_mm_, bulge_;
};

/// Number of marks from `first` on that make one batch: 1 or more unless there are none.
std::size_t BatchSizeAt(const mark::MarkSet& set, std::size_t first);

/// kTooLarge: more marks, places or pens than travel, with what to do.
Status CheckMarkRoom(const mark::MarkSet& set);

/// Appends the marks of `batch` to `set`, which has those of all before it. kFault:
/// arrays that disagree, values that are not possible, or more than is allowed; `set` is
/// unchanged then.
Status AppendMarks(const intaglio_MarkBatch& batch, mark::MarkSet& set);

/// Unlike a cloud of points, marks come in one part.
struct MarkCodec {
  using Batch = intaglio_MarkBatch;
  using Content = mark::MarkSet;
  using Columns = MarkColumns;
  static constexpr std::uint32_t kWindowBatches = 32;  // 6 MB in flight
  static constexpr const char* kItems = "marks";

  class Receiver {
   public:
    std::size_t size() const { return content.marks.size(); }
    /// kFault: as AppendMarks, and when more than kMaxPlaces have come.
    Status Append(const Batch& batch);
    mark::MarkSet content;

   private:
    std::uint64_t place_count_ = 0;
  };

  static TaskPart PartOf(const Batch& batch) { return {0, 1, batch.part_attempt}; }
  static std::uint64_t FirstOf(const Batch& batch) { return batch.first_mark; }
  static std::size_t CountOf(const Batch& batch) { return batch.pen._length; }
  static std::size_t SizeOf(const mark::MarkSet& set) { return set.marks.size(); }
  /// kFault: more than kMaxMarks, which no sender makes (CheckMarkRoom).
  static Status CheckTotal(const Batch& batch, std::uint64_t others);
  static mark::MarkSet Join(std::vector<mark::MarkSet> parts);
  static std::size_t CountAt(const mark::MarkSet& set, std::size_t first) {
    return BatchSizeAt(set, first);
  }
  static void SetPlace(Batch& batch, const TaskPart&, std::size_t first) {
    batch.first_mark = first;
  }
};

}  // namespace intaglio::host
