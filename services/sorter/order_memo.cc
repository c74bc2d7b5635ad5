#include "services/sorter/order_memo.h"

#include <algorithm>
#include <string_view>

#include "services/platform/access/hmac.h"

namespace intaglio::sorter {
namespace {

template <typename T>
std::string DigestOf(std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  return access::HmacSha256(
      "order",
      std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace

std::string OrderKey(const FrozenJob& job, const PointList& points_mm,
                     std::span<const ChannelMask> masks) {
  if (job.job().ordering().anneal().has_time_s()) return {};
  FrozenJob unnamed = job;
  unnamed.mutable_job()->clear_name();
  const std::string rest = unnamed.SerializeAsString();
  return DigestOf(std::span<const Vec3>(points_mm)) + DigestOf(masks) +
         DigestOf(std::span<const char>(rest));
}

std::optional<sort::Order> OrderMemo::Find(const std::string& key) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(newest_first_, key, &Entry::key);
  if (found == newest_first_.end()) return std::nullopt;
  newest_first_.splice(newest_first_.begin(), newest_first_, found);
  return found->order;
}

void OrderMemo::Keep(const std::string& key, const sort::Order& order) {
  if (key.empty() || !Keeps(order.size())) return;
  const std::scoped_lock lock(mutex_);
  points_ += order.size();
  newest_first_.push_front({key, order});
  while (points_ > max_points_) {
    points_ -= newest_first_.back().order.size();
    newest_first_.pop_back();
  }
}

}  // namespace intaglio::sorter
