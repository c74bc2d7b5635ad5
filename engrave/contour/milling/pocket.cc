#include "engrave/contour/milling/pocket.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/contour/option_range.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A strip or a part with less is the rounding of coordinates, mm2.
constexpr double kNothing_mm2 = 1e-6;
// The search for the largest tool that fits ends here, mm.
constexpr double kDiameter_mm = 1e-3;
constexpr std::size_t kPassesFromWall = 16;
constexpr double kMinStepRatio = 0.05;
// Where passes of two walls meet exactly, as in a slot of whole steps, the proof of their
// union fails: then with these parts of the step.
constexpr double kSmallerSteps[] = {0.98, 0.95};

Status CheckPocketOptions(const PocketOptions& options) {
  INTAGLIO_TRY(CheckOption("the tool's diameter", options.tool_diameter_mm, 0.001, 100));
  INTAGLIO_TRY(CheckOption("the step", options.step_ratio, kMinStepRatio, 0.95));
  INTAGLIO_TRY(CheckOption("the allowance", options.allowance_mm, 0, 10));
  return CheckOption("the number of passes", options.max_pass_count, 1, 1'000'000);
}

/// Halves the interval between a diameter that fits and one that does not.
double LargestTool_mm(const Region& part, double allowance_mm, double too_large_mm) {
  double fits = 0;
  double fits_not = too_large_mm;
  while (fits_not - fits > kDiameter_mm) {
    const double middle = 0.5 * (fits + fits_not);
    const auto inset = Inset(part, middle / 2 + allowance_mm);
    (inset && !inset->loops.empty() ? fits : fits_not) = middle;
  }
  return std::floor(fits / kDiameter_mm) * kDiameter_mm;
}

/// A part into which the tool fits nowhere would stay as it is.
Status CheckParts(const Region& area, const Region& first, const PocketOptions& options) {
  for (const Region& part : ConnectedParts(area)) {
    const auto is_in_part = [&](const Edges& path) {
      return IsInside(part, path.front().begin_mm);
    };
    if (std::any_of(first.loops.begin(), first.loops.end(), is_in_part)) continue;
    const double largest =
        LargestTool_mm(part, options.allowance_mm, options.tool_diameter_mm);
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
  Clearing(const Region& area, const PocketOptions& options)
      : area_(area),
        options_(options),
        radius_(options.tool_diameter_mm / 2),
        step_(options.tool_diameter_mm * options.step_ratio) {}

  Result<std::vector<PocketPass>> Run(Region first) {
    double offset = radius_ + options_.allowance_mm;
    Region paths = std::move(first);
    while (!paths.loops.empty()) {
      Region next = INTAGLIO_TRY(Farther(paths, step_, offset + step_));
      INTAGLIO_TRY(Append(offset, false, paths));
      if (step_ > radius_) INTAGLIO_TRY(AppendStrips(paths, offset + radius_, next));
      paths = std::move(next);
      offset += step_;
    }
    return std::move(passes_);
  }

 private:
  /// What is farther than border_mm from the wall is not yet cut: of its parts those stay
  /// that the next pass does not cut wholly, and their borders are a pass themselves.
  Status AppendStrips(const Region& paths, double border_mm, const Region& next) {
    const Region open = INTAGLIO_TRY(Farther(paths, radius_, border_mm));
    if (open.loops.empty()) return {};
    const auto uncut = Uncut(open, next);
    // Where that cannot be decided the whole border is run along: too much, never wrong.
    if (!uncut) return Append(border_mm, true, open);
    if (AreaOf(*uncut) < kNothing_mm2) return {};
    Region strips;
    for (const Edges& loop : open.loops) {
      if (Touches(loop, *uncut)) strips.loops.push_back(loop);
    }
    return Append(border_mm, true, std::move(strips));
  }

  /// What is by_mm farther from the wall than a pass: from the pass, which has few edges
  /// near each other, but every so often, and where that is refused, from the wall, so
  /// that roundings do not add up.
  Result<Region> Farther(const Region& paths, double by_mm, double offset_mm) const {
    if (passes_.size() % kPassesFromWall != 0) {
      if (auto inset = Inset(paths, by_mm)) return inset;
    }
    return Inset(area_, offset_mm);
  }

  /// The rest of what is open that neither the next pass cuts nor those behind it: they
  /// are inside of it.
  Result<Region> Uncut(const Region& open, const Region& next) const {
    if (next.loops.empty()) return open;
    const Region cut = INTAGLIO_TRY(Swept(next.loops, options_.tool_diameter_mm));
    const Region beside = INTAGLIO_TRY(Difference(open, cut));
    return Difference(beside, next);
  }

  bool Touches(const Edges& loop, const Region& uncut) const {
    for (const Region& part : ConnectedParts(uncut)) {
      if (AreaOf(part) < kNothing_mm2) continue;
      for (const Edge& edge : part.loops[0]) {
        const Vec2 place = PointAt(edge, edge.length_mm / 2);
        for (const Edge& border : loop) {
          if (DistanceTo(border, place) < step_ - radius_ + kDiameter_mm) return true;
        }
      }
    }
    return false;
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
  double radius_;
  double step_;
  std::vector<PocketPass> passes_;
};

Result<Region> CutBy(const std::vector<PocketPass>& passes, double tool_diameter_mm) {
  std::vector<Edges> paths;
  for (const PocketPass& pass : passes)
    paths.insert(paths.end(), pass.paths.begin(), pass.paths.end());
  return Swept(paths, tool_diameter_mm);
}

Result<Pocket> ClearWithStep(const Region& area, const PocketOptions& options) {
  Region first =
      INTAGLIO_TRY(Inset(area, options.tool_diameter_mm / 2 + options.allowance_mm));
  INTAGLIO_TRY(CheckParts(area, first, options));
  Pocket pocket;
  pocket.passes = INTAGLIO_TRY(Clearing(area, options).Run(std::move(first)));
  std::reverse(pocket.passes.begin(), pocket.passes.end());
  const Region cut = INTAGLIO_TRY(CutBy(pocket.passes, options.tool_diameter_mm));
  pocket.cut_area_mm2 = AreaOf(cut);
  const double whole_mm2 = options.allowance_mm > 0
                               ? AreaOf(INTAGLIO_TRY(Inset(area, options.allowance_mm)))
                               : AreaOf(area);
  pocket.left_area_mm2 = std::max(whole_mm2 - pocket.cut_area_mm2, 0.0);
  return pocket;
}

}  // namespace

Result<Pocket> ClearPocket(const Region& area, const PocketOptions& options) {
  INTAGLIO_TRY(CheckPocketOptions(options));
  auto pocket = ClearWithStep(area, options);
  PocketOptions smaller = options;
  for (const double part : kSmallerSteps) {
    if (pocket || pocket.error().code != ErrorCode::kUnsupported) break;
    smaller.step_ratio = std::max(kMinStepRatio, part * options.step_ratio);
    if (auto again = ClearWithStep(area, smaller)) pocket = std::move(again);
  }
  return pocket;
}

}  // namespace intaglio::contour
