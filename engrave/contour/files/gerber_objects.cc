#include "engrave/contour/files/gerber_objects.h"

#include <fmt/format.h>

#include <iterator>

#include "engrave/contour/region/region.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A run of clear objects is compared with the boxes of all objects before it.
constexpr std::uint64_t kMaxComparisons = 1'000'000'000;

}  // namespace

Error GerberObjects::TooMany() const {
  return {ErrorCode::kTooLarge,
          fmt::format("more than {} elements or {} edges; divide the layer",
                      limits_.max_elements, limits_.max_edges),
          {}};
}

Status GerberObjects::Add(Element object) {
  if (const auto* outline = std::get_if<Outline>(&object.shape)) {
    for (const Edges& loop : outline->loops) edge_count_ += loop.size();
  }
  if (objects_.size() >= limits_.max_elements || edge_count_ > 2 * limits_.max_edges)
    return tl::unexpected(TooMany());
  objects_.push_back(std::move(object));
  are_clear_.push_back(clear_ ? 1 : 0);
  return {};
}

Status GerberObjects::Repeat(const GerberRepeat& next) {
  const std::size_t end = objects_.size();
  const bool clear = clear_;
  for (int x = 0; x < repeat_.columns && end > repeat_begin_; ++x) {
    for (int y = 0; y < repeat_.rows; ++y) {
      if (x == 0 && y == 0) continue;
      const Vec2 by = repeat_.step_mm.cwiseProduct(Vec2(x, y));
      for (std::size_t k = repeat_begin_; k < end; ++k) {
        const Element first = objects_[k];
        clear_ = are_clear_[k] != 0;
        INTAGLIO_TRY(Add({Moved(first.shape, by), first.name, first.net}));
      }
    }
  }
  clear_ = clear;
  repeat_ = next;
  repeat_begin_ = objects_.size();
  return {};
}

Result<std::vector<Element>> GerberObjects::Finish() {
  INTAGLIO_TRY(Repeat({}));
  std::vector<Element> copper;
  std::uint64_t comparisons = 0;
  for (std::size_t begin = 0; begin < objects_.size();) {
    std::size_t end = begin;
    while (end < objects_.size() && are_clear_[end] == are_clear_[begin]) ++end;
    const std::vector<Element> run(
        std::make_move_iterator(objects_.begin() + static_cast<std::ptrdiff_t>(begin)),
        std::make_move_iterator(objects_.begin() + static_cast<std::ptrdiff_t>(end)));
    if (are_clear_[begin] == 0) {
      copper.insert(copper.end(), run.begin(), run.end());
    } else {
      comparisons += copper.size();
      if (comparisons > kMaxComparisons) return tl::unexpected(TooMany());
      copper = INTAGLIO_TRY(Cleared(copper, run));
      if (copper.size() > limits_.max_elements) return tl::unexpected(TooMany());
    }
    begin = end;
  }
  return copper;
}

}  // namespace intaglio::contour
