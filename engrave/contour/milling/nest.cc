#include "engrave/contour/milling/nest.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <optional>

#include "engrave/contour/milling/nest_outlines.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kFits_mm = 1e-9;

/// The upper border of what lies on a sheet: steps from the left to the right.
class Skyline {
 public:
  Skyline(double width, double height) : height_(height), steps_{{0, width, 0}} {}

  /// The lowest place of a box, of several the leftmost.
  std::optional<Vec2> PlaceFor(const Vec2& sides) const {
    std::optional<Vec2> best;
    for (std::size_t first = 0; first < steps_.size(); ++first) {
      const auto top = TopOver(first, sides.x());
      if (!top || *top + sides.y() > height_ + kFits_mm) continue;
      if (!best || *top < best->y() - kFits_mm) best = Vec2(steps_[first].begin, *top);
    }
    return best;
  }

  void Add(const Vec2& at, const Vec2& sides) {
    const double end = at.x() + sides.x();
    std::vector<Step> steps;
    for (const Step& step : steps_) {
      if (step.begin < at.x())
        steps.push_back({step.begin, std::min(step.end, at.x()), step.top});
    }
    steps.push_back({at.x(), end, at.y() + sides.y()});
    for (const Step& step : steps_) {
      if (step.end > end + kFits_mm)
        steps.push_back({std::max(step.begin, end), step.end, step.top});
    }
    steps_ = std::move(steps);
  }

 private:
  struct Step {
    double begin;
    double end;
    double top;
  };

  std::optional<double> TopOver(std::size_t first, double width) const {
    double top = 0;
    const double end = steps_[first].begin + width;
    for (std::size_t k = first; k < steps_.size(); ++k) {
      top = std::max(top, steps_[k].top);
      if (steps_[k].end >= end - kFits_mm) return top;
    }
    return std::nullopt;
  }

  double height_;
  std::vector<Step> steps_;
};

Edge TurnedEdge(Edge edge) {
  const auto turned = [](const Vec2& p) { return Vec2(-p.y(), p.x()); };
  edge.begin_mm = turned(edge.begin_mm);
  edge.end_mm = turned(edge.end_mm);
  edge.center_mm = turned(edge.center_mm);
  edge.begin_rad += std::numbers::pi / 2;
  return edge;
}

Status CheckNest(std::span<const Region> parts, const NestOptions& options) {
  const auto is_length = [](double length) { return length >= 0 && length <= 1000; };
  if (!(options.sheet_mm.minCoeff() > 0) || !is_length(options.gap_mm) ||
      !is_length(options.margin_mm))
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a sheet of {} x {} mm with a gap of {} and a margin of {} mm "
                    "is not possible; correct it",
                    options.sheet_mm.x(), options.sheet_mm.y(), options.gap_mm,
                    options.margin_mm));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].loops.empty() || parts[k].loops[0].empty())
      return Fail(ErrorCode::kInvalidValue, fmt::format("part {} has no contour", k));
  }
  return {};
}

enum class Preference {
  kLowest,   ///< upright or turned, as the sheet is used up less high
  kUpright,  ///< turned only where it does not fit upright
  kTurned,   ///< the other way round
};

class Nester {
 public:
  Nester(std::span<const Region> parts, const NestOptions& options, Preference preference)
      : parts_(parts), options_(options), preference_(preference) {
    // A gap belongs to the right and the upper side of each part, and of the sheet.
    room_ = options.sheet_mm + Vec2::Constant(options.gap_mm - 2 * options.margin_mm);
    for (const Region& part : parts) boxes_.push_back(BoxOfRegion(part));
  }

  Result<Nest> Run() {
    std::vector<std::uint32_t> order(parts_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return SidesOf(a).maxCoeff() > SidesOf(b).maxCoeff();
    });
    nest_.parts.resize(parts_.size());
    for (const std::uint32_t part : order) {
      if (!TryAll(part)) {
        skylines_.emplace_back(room_.x(), room_.y());
        if (!TryAll(part)) return TooLarge(part);
      }
    }
    nest_.sheet_count = static_cast<std::uint32_t>(skylines_.size());
    return std::move(nest_);
  }

 private:
  Vec2 SidesOf(std::uint32_t part) const {
    return boxes_[part].max_mm - boxes_[part].min_mm;
  }

  bool TryAll(std::uint32_t part) {
    for (std::uint32_t sheet = 0; sheet < skylines_.size(); ++sheet) {
      if (TrySheet(part, sheet)) return true;
    }
    return false;
  }

  bool TrySheet(std::uint32_t part, std::uint32_t sheet) {
    const Vec2 upright = SidesOf(part) + Vec2::Constant(options_.gap_mm);
    const Vec2 lying(upright.y(), upright.x());
    Skyline& skyline = skylines_[sheet];
    const auto at = skyline.PlaceFor(upright);
    const auto turned_at = options_.turn ? skyline.PlaceFor(lying) : std::nullopt;
    if (!at && !turned_at) return false;
    const bool turned = !at || (turned_at && IsTurnedBetter(at->y() + upright.y(),
                                                            turned_at->y() + lying.y()));
    const Vec2 place = turned ? *turned_at : *at;
    skyline.Add(place, turned ? lying : upright);
    const EdgeBox& box = boxes_[part];
    const Vec2 corner = turned ? Vec2(-box.max_mm.y(), box.min_mm.x()) : box.min_mm;
    nest_.parts[part] = {part, sheet, place + Vec2::Constant(options_.margin_mm) - corner,
                         turned ? 1 : 0};
    return true;
  }

  bool IsTurnedBetter(double upright_top, double turned_top) const {
    if (preference_ == Preference::kLowest) return turned_top < upright_top;
    return preference_ == Preference::kTurned;
  }

  tl::unexpected<Error> TooLarge(std::uint32_t part) const {
    const Vec2 sides = SidesOf(part);
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("part {} of {:.4g} x {:.4g} mm does not fit into a sheet of "
                            "{:.4g} x {:.4g} mm with a margin of {:.4g} mm",
                            part, sides.x(), sides.y(), options_.sheet_mm.x(),
                            options_.sheet_mm.y(), options_.margin_mm));
  }

  std::span<const Region> parts_;
  const NestOptions& options_;
  Preference preference_;
  Vec2 room_;
  std::vector<EdgeBox> boxes_;
  std::vector<Skyline> skylines_;
  Nest nest_;
};

void Measure(std::span<const Region> parts, const NestOptions& options, Nest& nest) {
  double used_mm2 = 0;
  for (const NestedPart& place : nest.parts) {
    const Region placed = Placed(parts[place.part], place);
    used_mm2 += AreaOf(placed);
    if (place.sheet + 1 == nest.sheet_count)
      nest.last_top_mm = std::max(nest.last_top_mm, BoxOfRegion(placed).max_mm.y());
  }
  if (nest.sheet_count > 0)
    nest.use_percent = 100 * used_mm2 / (nest.sheet_count * options.sheet_mm.prod());
}

bool IsBetter(const Nest& a, const Nest& b) {
  return a.sheet_count < b.sheet_count ||
         (a.sheet_count == b.sheet_count && a.last_top_mm < b.last_top_mm - kFits_mm);
}

}  // namespace

Result<Nest> NestParts(std::span<const Region> parts, const NestOptions& options) {
  INTAGLIO_TRY(CheckNest(parts, options));
  std::optional<Nest> best;
  for (const Preference preference :
       {Preference::kLowest, Preference::kUpright, Preference::kTurned}) {
    Nest nest = INTAGLIO_TRY(Nester(parts, options, preference).Run());
    Measure(parts, options, nest);
    if (!best || IsBetter(nest, *best)) best = std::move(nest);
  }
  for (Nest& nest : NestOutlines(parts, options)) {
    Measure(parts, options, nest);
    if (IsBetter(nest, *best)) best = std::move(nest);
  }
  return *best;
}

Region Placed(const Region& part, const NestedPart& place) {
  Region placed = part;
  for (Edges& loop : placed.loops) {
    for (Edge& edge : loop) {
      for (int k = 0; k < place.quarter_turns; ++k) edge = TurnedEdge(edge);
      edge.begin_mm += place.moved_mm;
      edge.end_mm += place.moved_mm;
      edge.center_mm += place.moved_mm;
    }
  }
  return placed;
}

}  // namespace intaglio::contour
