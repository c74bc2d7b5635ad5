#include "services/replayer/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>

#include "engrave/core/counted.h"

namespace intaglio::replayer {
namespace {

bool Same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

struct Found {
  std::string member, then, now;
};

/// Compares one point.
std::optional<Found> ComparePoint(const CloudBatch& a, const CloudBatch& b,
                                  std::size_t i) {
  const auto text = [](double value) { return fmt::format("{}", value); };
  if (!Same(a.x_mm[i], b.x_mm[i])) return Found{"x_mm", text(a.x_mm[i]), text(b.x_mm[i])};
  if (!Same(a.y_mm[i], b.y_mm[i])) return Found{"y_mm", text(a.y_mm[i]), text(b.y_mm[i])};
  if (!Same(a.z_mm[i], b.z_mm[i])) return Found{"z_mm", text(a.z_mm[i]), text(b.z_mm[i])};
  if (a.source[i] == b.source[i]) return std::nullopt;
  return Found{"source", std::to_string(a.source[i]), std::to_string(b.source[i])};
}

/// Header fields of a batch.
std::optional<Found> CompareHeads(const CloudBatch& a, const CloudBatch& b) {
  const std::tuple<const char*, std::uint64_t, std::uint64_t> heads[] = {
      {"total_count", a.total_count, b.total_count},
      {"points", a.x_mm.size(), b.x_mm.size()},
      {"first_index", a.first_index, b.first_index},
      {"sequence_number", a.sequence_number, b.sequence_number},
      {"part_count", a.part_count, b.part_count},
      {"last", a.last ? 1 : 0, b.last ? 1 : 0}};
  for (const auto& [name, then, now] : heads) {
    if (then != now) return Found{name, std::to_string(then), std::to_string(now)};
  }
  return std::nullopt;
}

std::string Tokens(const CloudBatch& batch) {
  return fmt::format("{} of {}", Counted(batch.x_mm.size(), "point"), batch.total_count);
}

}  // namespace

std::optional<SampleDifference> Compare(const CloudBatch* then, const CloudBatch* now) {
  const CloudBatch& any = then != nullptr ? *then : *now;
  std::optional<Found> found;
  std::size_t index = 0;
  if (then == nullptr || now == nullptr) {
    found = Found{"batch", then == nullptr ? "none" : Tokens(*then),
                  now == nullptr ? "none" : Tokens(*now)};
  } else {
    const std::size_t size = std::min(then->x_mm.size(), now->x_mm.size());
    while (index < size && !(found = ComparePoint(*then, *now, index))) ++index;
    if (!found) found = CompareHeads(*then, *now);
  }
  if (!found) return std::nullopt;
  SampleDifference difference;
  difference.set_job_uid(any.id.job_uid);
  difference.set_attempt(any.id.attempt);
  difference.set_part(any.id.part);
  difference.set_batch(any.sequence_number);
  difference.set_index(index);
  difference.set_point(any.first_index + index);
  difference.set_member(found->member);
  difference.set_then(found->then);
  difference.set_now(found->now);
  return difference;
}

}  // namespace intaglio::replayer
