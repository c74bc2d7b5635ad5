#pragma once

// The newest orders of a sorter, so that pieces after the first one of the same job are
// not ordered again. Any thread may call it.

#include <cstddef>
#include <list>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/sort/order.h"
#include "proto/task.pb.h"

namespace intaglio::sorter {

/// The same for jobs whose points, channels and all else but their names are the same.
/// Empty when an order depends on more: on the time that it took (AnnealOrder.time_s).
std::string OrderKey(const FrozenJob& job, const PointList& points_mm,
                     std::span<const ChannelMask> masks);

class OrderMemo {
 public:
  /// It keeps orders of as many points in all, 4 bytes each.
  explicit OrderMemo(std::size_t max_points) : max_points_(max_points) {}

  /// Whether an order of so many points is kept.
  bool Keeps(std::size_t point_count) const { return point_count <= max_points_; }
  std::optional<sort::Order> Find(const std::string& key);
  /// Forgets the orders that were used the longest ago. An order with an empty key, or
  /// with more points than all may have, is not kept.
  void Keep(const std::string& key, const sort::Order& order);

 private:
  struct Entry {
    std::string key;
    sort::Order order;
  };

  std::size_t max_points_;
  std::mutex mutex_;
  std::list<Entry> newest_first_;
  std::size_t points_ = 0;  ///< of all orders
};

}  // namespace intaglio::sorter
