#include "engrave/galvo/web_follower.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::galvo {
namespace {

constexpr double kMaxRing = 1e7;  // counts between sensor and field

}  // namespace

Status CheckFollower(const WebFollowerOptions& options) {
  const auto fail = [](const char* name, double value, const char* remedy) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("follower: {} is {}; give {}", name, value, remedy),
                fmt::format("{}", value));
  };
  if (!(options.count_mm > 0 && options.count_mm <= 10))
    return fail("count_mm", options.count_mm, "more than 0 and up to 10");
  if (!(options.period_s > 0 && options.period_s <= 1))
    return fail("period_s", options.period_s, "more than 0 and up to 1");
  if (!(options.alpha > 0 && options.alpha <= 1))
    return fail("alpha", options.alpha, "more than 0 and up to 1");
  if (!(options.beta > 0 && options.beta < 4 - 2 * options.alpha))
    return fail("beta", options.beta, "more than 0 and less than 4 - 2 alpha");
  if (!(options.preview_s >= 0 && options.preview_s <= 1))
    return fail("preview_s", options.preview_s, "0..1");
  if (!(options.edge_sensor_upstream_mm >= 0 &&
        options.edge_sensor_upstream_mm / options.count_mm <= kMaxRing))
    return fail("edge_sensor_upstream_mm", options.edge_sensor_upstream_mm,
                "0 or more, and at most 10 million counts");
  return {};
}

WebFollower::WebFollower(const WebFollowerOptions& options, std::int64_t count,
                         double speed_mm_s)
    : options_(options),
      first_count_(count),
      last_count_(count),
      speed_mm_(speed_mm_s * options.period_s),
      preview_ticks_(options.preview_s / options.period_s + 0.5) {
  const Status checked = CheckFollower(options);
  Require(checked.has_value(), "{}", checked ? "" : checked.error().message);
  edges_mm_.assign(static_cast<std::size_t>(
                       std::lround(options.edge_sensor_upstream_mm / options.count_mm)) +
                       1,
                   0.0);
}

double WebFollower::EdgeInField(std::int64_t count, double edge_mm) {
  const auto ring = static_cast<std::int64_t>(edges_mm_.size());
  const auto at = [&](std::int64_t c) -> double& {
    return edges_mm_[static_cast<std::size_t>(((c % ring) + ring) % ring)];
  };
  // Counts that were passed since the last tick have this edge too; those of a web that
  // goes back keep theirs.
  const std::int64_t from = std::max(last_count_ + 1, count - ring + 1);
  for (std::int64_t c = from; c <= count; ++c) at(c) = edge_mm;
  if (count == first_count_) at(count) = edge_mm;
  last_count_ = std::max(last_count_, count);
  return at(last_count_ + 1);  // the oldest: as many counts ago as the way has
}

Vec2 WebFollower::Update(std::int64_t count, double edge_mm) {
  // Within its count the web is anywhere, now as at the first: on average the same.
  const double measured_mm =
      static_cast<double>(count - first_count_) * options_.count_mm;
  place_mm_ += speed_mm_;
  const double by_mm = measured_mm - place_mm_;
  place_mm_ += options_.alpha * by_mm;
  speed_mm_ += options_.beta * by_mm;
  return {place_mm_ + preview_ticks_ * speed_mm_, EdgeInField(count, edge_mm)};
}

}  // namespace intaglio::galvo
