#include "services/platform/host/stage/point_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

using bus::View;

template <typename Batch>
Status CheckColumns(const Batch& batch) {
  const std::size_t count = batch.x_mm._length;
  std::string what;
  if (batch.y_mm._length != count || batch.z_mm._length != count ||
      batch.source._length != count) {
    what = fmt::format("x_mm, y_mm, z_mm and source have {}, {}, {} and {} values", count,
                       batch.y_mm._length, batch.z_mm._length, batch.source._length);
  } else if (count > kBatchPoints) {
    what = fmt::format("it has {} points, above {}", count, kBatchPoints);
  } else {
    return {};
  }
  return Fail(ErrorCode::kFault,
              fmt::format("point batch {}: {}: the sender has another version or is "
                          "faulty; restart it and submit the job again",
                          batch.sequence_number, what));
}

}  // namespace

template <typename Batch>
Status PointCodec<Batch>::Receiver::Append(const Batch& batch) {
  INTAGLIO_TRY(CheckColumns(batch));
  const auto x = View(batch.x_mm), y = View(batch.y_mm), z = View(batch.z_mm);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (Vec3(x[i], y[i], z[i]).allFinite()) continue;
    return Fail(ErrorCode::kFault,
                fmt::format("point {} is not a finite number", content.size() + i));
  }
  const auto source = View(batch.source);
  content.points_mm.reserve(batch.total_count);
  content.source.reserve(batch.total_count);
  for (std::size_t i = 0; i < x.size(); ++i) {
    content.Add(Vec3(x[i], y[i], z[i]), source[i]);
  }
  return {};
}

template <typename Batch>
PointCodec<Batch>::Columns::Columns(const PointCloud& cloud, std::size_t first,
                                    std::size_t count)
    : x_mm_(count), y_mm_(count), z_mm_(count) {
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& p_mm = cloud.points_mm[first + i];
    x_mm_[i] = p_mm.x(), y_mm_[i] = p_mm.y(), z_mm_[i] = p_mm.z();
  }
  const auto begin = cloud.source.begin() + static_cast<std::ptrdiff_t>(first);
  source_.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
}

template <typename Batch>
void PointCodec<Batch>::Columns::BorrowTo(Batch& batch) const {
  bus::Borrow(batch.x_mm, x_mm_);
  bus::Borrow(batch.y_mm, y_mm_);
  bus::Borrow(batch.z_mm, z_mm_);
  bus::Borrow(batch.source, source_);
}

template <typename Batch>
Status PointCodec<Batch>::CheckTotal(const Batch& batch, std::uint64_t others) {
  if (batch.total_count <= kMaxCloudPoints - std::min(others, kMaxCloudPoints)) return {};
  return Fail(
      ErrorCode::kTooLarge,
      fmt::format("a cloud of {} points exceeds the {} allowed: use a larger spacing",
                  others + batch.total_count, kMaxCloudPoints),
      std::to_string(batch.total_count));
}

template <typename Batch>
PointCloud PointCodec<Batch>::Join(std::vector<PointCloud> parts) {
  if (parts.empty()) return {};
  PointCloud cloud = std::move(parts.front());
  std::size_t size = cloud.size();
  for (std::size_t i = 1; i < parts.size(); ++i) size += parts[i].size();
  cloud.points_mm.reserve(size);
  cloud.source.reserve(size);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const PointCloud part = std::exchange(parts[i], {});
    cloud.points_mm.insert(cloud.points_mm.end(), part.points_mm.begin(),
                           part.points_mm.end());
    cloud.source.insert(cloud.source.end(), part.source.begin(), part.source.end());
  }
  return cloud;
}

template struct PointCodec<intaglio_PointBatch>;
template struct PointCodec<intaglio_PathBatch>;

}  // namespace intaglio::host
