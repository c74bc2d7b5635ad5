#include "engrave/contour/union_proof.h"

#include <algorithm>

namespace intaglio::contour {
namespace {

constexpr double kAllowedDepth_mm = 2e-6;
// An omitted edge is covered when a point so far outside of it is in an area, mm: far
// above the rounding of doubles. Of several edges that run along each other the
// outermost is not, so a fragment has to remain.
constexpr double kOutside_mm = 1e-8;
constexpr std::size_t kFragmentsAReport = 256;

/// The neighbours of every area, and the fragments of every area.
class Prover {
 public:
  Prover(std::span<const Area> areas, std::span<const Pair> pairs, const Remains& remains)
      : areas_(areas),
        remains_(remains),
        neighbours_begin_(areas.size() + 1, 0),
        fragments_begin_(areas.size() + 1, 0) {
    for (const Pair& pair : pairs) {
      ++neighbours_begin_[pair.first + 1];
      ++neighbours_begin_[pair.second + 1];
    }
    for (const Fragment& fragment : remains.fragments)
      ++fragments_begin_[fragment.area + 1];
    for (std::size_t k = 1; k < neighbours_begin_.size(); ++k) {
      neighbours_begin_[k] += neighbours_begin_[k - 1];
      fragments_begin_[k] += fragments_begin_[k - 1];
    }
    neighbours_.resize(2 * pairs.size());
    std::vector<std::size_t> at(neighbours_begin_.begin(), neighbours_begin_.end() - 1);
    for (const Pair& pair : pairs) {
      neighbours_[at[pair.first]++] = pair.second;
      neighbours_[at[pair.second]++] = pair.first;
    }
  }

  std::optional<Refusal> CheckFragments(const ProgressSink& progress) const {
    const std::size_t count = remains_.fragments.size();
    for (std::size_t k = 0; k < count; ++k) {
      if (progress && k % kFragmentsAReport == 0 && !progress(k, count)) break;
      const Fragment& fragment = remains_.fragments[k];
      for (const double part : {0.25, 0.5, 0.75}) {
        const Vec2 place = PointAt(fragment.edge, part * fragment.edge.length_mm);
        if (IsCovered(fragment.area, place, kAllowedDepth_mm))
          return Refusal{"has a contour through another one", place, fragment.area};
      }
    }
    return std::nullopt;
  }

  std::optional<Refusal> CheckOmissions() const {
    for (const Omission& omission : remains_.omissions) {
      const Vec2 outside = omission.place_mm + kOutside_mm * omission.outward;
      if (IsCovered(omission.area, outside, 0) || HasFragment(omission)) continue;
      return Refusal{"would lose a part of its contour", omission.place_mm,
                     omission.area};
    }
    return std::nullopt;
  }

 private:
  bool IsCovered(std::uint32_t area, const Vec2& place, double depth) const {
    for (std::size_t k = neighbours_begin_[area]; k < neighbours_begin_[area + 1]; ++k) {
      const Area& other = areas_[neighbours_[k]];
      if ((place.array() < other.min_mm.array()).any() ||
          (place.array() > other.max_mm.array()).any())
        continue;
      if (Depth(other, place) < -depth) return true;
    }
    return false;
  }

  bool HasFragment(const Omission& omission) const {
    if (IsFragmentAt(omission.area, omission.place_mm)) return true;
    for (std::size_t k = neighbours_begin_[omission.area];
         k < neighbours_begin_[omission.area + 1]; ++k) {
      if (IsFragmentAt(neighbours_[k], omission.place_mm)) return true;
    }
    return false;
  }

  bool IsFragmentAt(std::uint32_t area, const Vec2& place) const {
    for (std::size_t f = fragments_begin_[area]; f < fragments_begin_[area + 1]; ++f) {
      if (DistanceTo(remains_.fragments[f].edge, place) < kVertex_mm) return true;
    }
    return false;
  }

  std::span<const Area> areas_;
  const Remains& remains_;
  std::vector<std::size_t> neighbours_begin_;
  std::vector<std::uint32_t> neighbours_;
  std::vector<std::size_t> fragments_begin_;  ///< fragments lie area by area
};

std::optional<Refusal> CheckClosed(const Remains& remains,
                                   std::span<const ChainedContour> contours) {
  for (const ChainedContour& contour : contours) {
    if (contour.closed) continue;
    const Fragment& last = remains.fragments[contour.fragments.back()];
    return Refusal{"has a contour that does not close", last.edge.end_mm, last.area};
  }
  return std::nullopt;
}

/// A group without an outer contour was lost as a whole.
std::optional<Refusal> CheckGroups(std::span<const Area> areas, const Remains& remains,
                                   std::span<const ChainedContour> contours,
                                   std::span<const std::uint32_t> groups) {
  std::vector<char> drawn(groups.size(), 0);
  for (const ChainedContour& contour : contours) {
    double twice = 0;
    for (const std::uint32_t f : contour.fragments)
      twice += TwiceSweptArea(remains.fragments[f].edge);
    if (twice > 0) drawn[groups[remains.fragments[contour.fragments[0]].area]] = 1;
  }
  for (std::uint32_t area = 0; area < areas.size(); ++area) {
    if (!drawn[groups[area]])
      return Refusal{"would lose its contour", areas[area].edges[0].begin_mm, area};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Refusal> Prove(std::span<const Area> areas, std::span<const Pair> pairs,
                             const Remains& remains,
                             std::span<const ChainedContour> contours,
                             std::span<const std::uint32_t> groups,
                             const ProgressSink& progress) {
  if (auto refusal = CheckClosed(remains, contours)) return refusal;
  const Prover prover(areas, pairs, remains);
  if (auto refusal = prover.CheckFragments(progress)) return refusal;
  if (auto refusal = prover.CheckOmissions()) return refusal;
  return CheckGroups(areas, remains, contours, groups);
}

}  // namespace intaglio::contour
