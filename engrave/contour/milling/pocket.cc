#include "engrave/contour/milling/pocket.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/option_range.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/contour/region/simplify.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A strip or a part with less is the rounding of coordinates, mm2.
constexpr double kNothing_mm2 = 1e-6;
// The search for the largest tool that fits ends here, mm; of an area of many edges at
// this share of it.
constexpr double kDiameter_mm = 1e-3;
constexpr double kDiameterShare = 0.1;
constexpr double kMinStepRatio = 0.05;
// Where passes of two walls meet exactly, as in a slot of whole steps, the proof of their
// union fails: then with these parts of the step.
constexpr double kParts[] = {1, 0.98, 0.95, 0.9};
constexpr double kMaxTolerance_mm = 0.002;
constexpr double kToleranceOfStep = 0.01;
constexpr int kPassesFromWall = 16;

Status CheckPocketOptions(const PocketOptions& options) {
  INTAGLIO_TRY(CheckOption("the tool's diameter", options.tool_diameter_mm, 0.001, 100));
  INTAGLIO_TRY(CheckOption("the step", options.step_ratio, kMinStepRatio, 0.95));
  INTAGLIO_TRY(CheckOption("the allowance", options.allowance_mm, 0, 10));
  return CheckOption("the number of passes", options.max_pass_count, 1, 1'000'000);
}

/// Insets of one area and of the passes in it: exact, or in stages.
struct Insets {
  double tolerance_mm = 0;  ///< 0: exact

  /// At least so far from the wall, and at most twice the tolerance more.
  Result<Region> FromWall(const Region& area, double distance_mm) const {
    if (tolerance_mm == 0) return Inset(area, distance_mm);
    return InsetInStages(area, distance_mm + tolerance_mm, tolerance_mm);
  }
  /// At most so far from a pass, and at least twice the tolerance less.
  Result<Region> FromPass(const Region& paths, double distance_mm) const {
    if (tolerance_mm == 0) return Inset(paths, distance_mm);
    return InsetInStages(paths, distance_mm - tolerance_mm, tolerance_mm);
  }
};

/// Halves the interval between a diameter that fits and one that does not.
double LargestTool_mm(const Region& part, const Insets& insets, double allowance_mm,
                      double too_large_mm) {
  double fits = 0;
  double fits_not = too_large_mm;
  const double share = insets.tolerance_mm > 0 ? kDiameterShare : 0;
  while (fits_not - fits > std::max(kDiameter_mm, share * fits_not)) {
    const double middle = 0.5 * (fits + fits_not);
    const auto inset = insets.FromWall(part, middle / 2 + allowance_mm);
    (inset && !inset->loops.empty() ? fits : fits_not) = middle;
  }
  return std::floor(fits / kDiameter_mm) * kDiameter_mm;
}

/// A part into which the tool fits nowhere would stay as it is.
Status CheckParts(const Region& area, const Region& first, const Insets& insets,
                  const PocketOptions& options) {
  for (const Region& part : ConnectedParts(area)) {
    const RegionIndex index(part);
    const auto is_in_part = [&](const Edges& path) {
      return index.IsInside(path.front().begin_mm);
    };
    if (std::any_of(first.loops.begin(), first.loops.end(), is_in_part)) continue;
    const double largest =
        LargestTool_mm(part, insets, options.allowance_mm, options.tool_diameter_mm);
    const Vec2& at = part.loops[0][0].begin_mm;
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the tool of {:.4g} mm does not fit into the pocket at "
                            "({:.4g}, {:.4g}); use one of {:.4g} mm or less",
                            options.tool_diameter_mm, at.x(), at.y(), largest),
                fmt::format("{:.6g}", largest));
  }
  return {};
}

/// The passes from the wall on.
class Clearing {
 public:
  Clearing(const Region& area, const PocketOptions& options, const Insets& insets)
      : area_(area),
        options_(options),
        insets_(insets),
        radius_(options.tool_diameter_mm / 2),
        step_(options.tool_diameter_mm * options.step_ratio) {}

  Result<std::vector<PocketPass>> Run(Region first) {
    double offset = radius_ + options_.allowance_mm;
    Region paths = std::move(first);
    while (!paths.loops.empty()) {
      Neighbour next = INTAGLIO_TRY(Farther(paths, offset, step_));
      INTAGLIO_TRY(Append(offset, false, paths));
      if (step_ > radius_) INTAGLIO_TRY(AppendStrips(paths, offset, next.paths));
      passes_from_wall_ = next.from_wall ? 1 : passes_from_wall_ + 1;
      paths = std::move(next.paths);
      offset += next.apart_mm;
    }
    return std::move(passes_);
  }

 private:
  struct Neighbour {
    Region paths;
    double apart_mm = 0;  ///< from the pass
    bool from_wall = false;
  };

  /// What is by_mm farther from the wall than a pass: from the pass, which has few edges
  /// near each other. Of few edges every so often, and where that is refused, from the
  /// wall, so that roundings do not add up. Where both fail it is nearer.
  Result<Neighbour> Farther(const Region& paths, double offset_mm, double by_mm) const {
    const bool exact = insets_.tolerance_mm == 0;
    const bool wall_first = exact && passes_from_wall_ % kPassesFromWall == 0;
    std::optional<Error> first;
    for (const double part : kParts) {
      for (const bool wall : {wall_first, !wall_first}) {
        if (wall && !exact) continue;
        const double apart_mm = part * by_mm;
        auto next = wall ? insets_.FromWall(area_, offset_mm + apart_mm)
                         : insets_.FromPass(paths, apart_mm);
        if (next) return Neighbour{std::move(*next), apart_mm, wall};
        if (next.error().code != ErrorCode::kUnsupported)
          return tl::unexpected(next.error());
        if (!first) first = next.error();
      }
    }
    return tl::unexpected(*first);
  }

  /// What is farther than the radius from a pass is not yet cut: of its parts those stay
  /// that the next pass does not cut wholly, and their borders are a pass themselves.
  Status AppendStrips(const Region& paths, double offset_mm, const Region& next) {
    const Neighbour border = INTAGLIO_TRY(Farther(paths, offset_mm, radius_));
    const Region& open = border.paths;
    if (open.loops.empty()) return {};
    const double border_mm = offset_mm + border.apart_mm;
    const auto uncut = Uncut(open, next);
    // Where that cannot be decided the whole border is run along: too much, never wrong.
    if (!uncut) return Append(border_mm, true, open);
    if (AreaOf(*uncut) < kNothing_mm2) return {};
    const std::vector<Vec2> places = PlacesOf(*uncut);
    Region strips;
    for (const Edges& loop : open.loops) {
      const EdgeTree tree(loop);
      const double reach_mm = step_ - border.apart_mm + kDiameter_mm;
      if (std::any_of(places.begin(), places.end(), [&](const Vec2& place) {
            return tree.DistanceTo(place) < reach_mm;
          }))
        strips.loops.push_back(loop);
    }
    return Append(border_mm, true, std::move(strips));
  }

  /// The rest of what is open that neither the next pass cuts nor those behind it: they
  /// are inside of it.
  Result<Region> Uncut(const Region& open, const Region& next) const {
    if (next.loops.empty()) return open;
    const Region cut = INTAGLIO_TRY(Swept(next.loops, options_.tool_diameter_mm));
    const Region beside = INTAGLIO_TRY(Difference(open, cut));
    return Difference(beside, next);
  }

  /// Places on the borders of the parts, but for those that are nothing.
  static std::vector<Vec2> PlacesOf(const Region& uncut) {
    std::vector<Vec2> places;
    for (const Region& part : ConnectedParts(uncut)) {
      if (AreaOf(part) < kNothing_mm2) continue;
      for (const Edge& edge : part.loops[0])
        places.push_back(PointAt(edge, edge.length_mm / 2));
    }
    return places;
  }

  Status Append(double offset_mm, bool between, Region paths) {
    if (static_cast<int>(passes_.size()) >= options_.max_pass_count)
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("the pocket needs more than {} passes; use a wider tool",
                              options_.max_pass_count));
    passes_.push_back({offset_mm, between, std::move(paths.loops)});
    return {};
  }

  const Region& area_;
  const PocketOptions& options_;
  const Insets& insets_;
  double radius_;
  double step_;
  int passes_from_wall_ = 0;  ///< made since the last one that was
  std::vector<PocketPass> passes_;
};

}  // namespace

Result<Pocket> ClearPocket(const Region& area, const PocketOptions& options) {
  INTAGLIO_TRY(CheckPocketOptions(options));
  const double radius_mm = options.tool_diameter_mm / 2;
  const double tolerance_mm = std::min(
      kMaxTolerance_mm, kToleranceOfStep * options.step_ratio * options.tool_diameter_mm);
  Pocket pocket;
  const Insets insets{HasManyEdges(area) ? tolerance_mm : 0};
  pocket.tolerance_mm = 2 * insets.tolerance_mm;
  Region first = INTAGLIO_TRY(insets.FromWall(area, radius_mm + options.allowance_mm));
  INTAGLIO_TRY(CheckParts(area, first, insets, options));
  // The passes leave nothing inside of the first one.
  pocket.cut_area_mm2 = AreaOf(INTAGLIO_TRY(Outset(first, radius_mm)));
  const double whole_mm2 =
      options.allowance_mm > 0
          ? AreaOf(INTAGLIO_TRY(insets.FromWall(area, options.allowance_mm)))
          : AreaOf(area);
  pocket.left_area_mm2 = std::max(whole_mm2 - pocket.cut_area_mm2, 0.0);
  pocket.passes = INTAGLIO_TRY(Clearing(area, options, insets).Run(std::move(first)));
  std::reverse(pocket.passes.begin(), pocket.passes.end());
  return pocket;
}

}  // namespace intaglio::contour
