#include "engrave/contour/union.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engrave/contour/area.h"
#include "engrave/contour/equal_elements.h"
#include "engrave/contour/fragments.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/contour/union_proof.h"
#include "engrave/core/groups.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kNear_mm = 1e-3;
constexpr double kMaxRadius_mm = 100;
// A pair takes some hundred bytes.
constexpr std::uint64_t kMaxUnitedPairs = 12'000'000;
// Edges nearer than the first run along each other. Where that leaves the proof
// unsatisfied (three edges, the outer ones farther from each other), the next is tried.
constexpr double kTolerances_mm[] = {1e-7, 1e-9, 2e-6, 4e-6};
// Shares of the work: where areas meet, what remains of their edges, the proof.
constexpr std::uint64_t kWork = 1000, kMeetWork = 400, kRemainsWork = 600;
constexpr std::size_t kPairsAReport = 1024;

/// The sink of a union, in shares of kWork; it remembers that the work was cancelled.
class Progress {
 public:
  explicit Progress(const ProgressSink& sink) : sink_(sink) {}
  /// The share done / total of the work from `begin` to `end`; false: cancelled.
  bool Report(std::uint64_t begin, std::uint64_t end, std::uint64_t done,
              std::uint64_t total) {
    const std::uint64_t part = total == 0 ? 0 : (end - begin) * done / total;
    if (sink_ && !cancelled_) cancelled_ = !sink_(begin + part, kWork);
    return !cancelled_;
  }
  bool cancelled() const { return cancelled_; }

 private:
  const ProgressSink& sink_;
  bool cancelled_ = false;
};

struct Attempt {
  Remains remains;
  std::vector<ChainedContour> contours;
  std::vector<std::uint32_t> groups;  ///< of each area
  std::optional<Refusal> refusal;
};

Attempt TryTolerance(std::span<const Area> areas, std::span<const Pair> pairs,
                     double tolerance_mm, Progress& progress) {
  CoverFinder finder(areas, tolerance_mm);
  Groups groups(areas.size());
  std::vector<Cover> covers;
  covers.reserve(4 * pairs.size());
  Attempt attempt;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (k % kPairsAReport == 0 && !progress.Report(0, kMeetWork, k, pairs.size()))
      return attempt;
    if (finder.Find(pairs[k], covers)) groups.Join(pairs[k].first, pairs[k].second);
  }
  attempt.remains = RemainsOf(areas, finder, covers);
  attempt.contours = Chain(attempt.remains.fragments);
  for (std::uint32_t area = 0; area < areas.size(); ++area)
    attempt.groups.push_back(groups.Find(area));
  attempt.refusal = Prove(areas, pairs, attempt.remains, attempt.contours, attempt.groups,
                          [&](std::uint64_t done, std::uint64_t total) {
                            return progress.Report(kRemainsWork, kWork, done, total);
                          });
  return attempt;
}

Contour MakeContour(std::span<const Area> areas, const Remains& remains,
                    const ChainedContour& chained) {
  Contour contour;
  contour.edges = Joined(remains.fragments, chained.fragments);
  contour.area_mm2 = AreaOf(contour.edges);
  contour.inner = contour.area_mm2 < 0;
  contour.length_mm = LengthOf(contour.edges);
  for (const std::uint32_t f : chained.fragments)
    contour.elements.push_back(areas[remains.fragments[f].area].element);
  std::sort(contour.elements.begin(), contour.elements.end());
  contour.elements.erase(std::unique(contour.elements.begin(), contour.elements.end()),
                         contour.elements.end());
  return contour;
}

/// Groups of elements, numbered in their order: the areas of one element belong together.
/// An element that is drawn again has the areas of its first.
void NumberGroups(std::span<const Area> areas, std::span<const std::uint32_t> of_areas,
                  std::span<const std::uint32_t> firsts, Union& result) {
  Groups joined(areas.size());
  std::vector<std::uint32_t> area_of(firsts.size(), UINT32_MAX);
  for (std::uint32_t a = 0; a < areas.size(); ++a) {
    joined.Join(a, of_areas[a]);
    std::uint32_t& first = area_of[areas[a].element];
    if (first == UINT32_MAX)
      first = a;
    else
      joined.Join(first, a);
  }
  std::vector<std::uint32_t> numbers(areas.size(), UINT32_MAX);
  for (const std::uint32_t first : firsts) {
    std::uint32_t& number = numbers[joined.Find(area_of[first])];
    if (number == UINT32_MAX) number = result.group_count++;
    result.groups.push_back(number);
  }
}

tl::unexpected<Error> Refuse(const Refusal& refusal, const Element& element) {
  const Vec2& at = refusal.place_mm;
  return Fail(ErrorCode::kUnsupported,
              fmt::format("{} {} at ({:.6f}, {:.6f}) mm, where elements nearly touch; "
                          "move or resize one of them there by 0.001 mm",
                          Describe(element), refusal.sentence, at.x(), at.y()),
              fmt::format("{:.6f}, {:.6f}", at.x(), at.y()));
}

Result<std::vector<Area>> GrownAreas(std::span<const Element> elements,
                                     std::span<const std::uint32_t> firsts,
                                     const UnionOptions& options) {
  std::vector<Area> areas;
  areas.reserve(elements.size());
  for (std::uint32_t k = 0; k < elements.size(); ++k) {
    if (firsts[k] != k) continue;
    INTAGLIO_TRY(
        AppendGrown(elements[k], k, options.tool_radius_mm, options.corners, areas));
  }
  return areas;
}

}  // namespace

Result<Union> Unite(std::span<const Element> elements, const UnionOptions& options) {
  if (!(options.tool_radius_mm >= 0 && options.tool_radius_mm <= kMaxRadius_mm))
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("the tool's radius {} mm is not within 0 .. {} mm; correct it",
                    options.tool_radius_mm, kMaxRadius_mm));
  const std::vector<Element> rounded = INTAGLIO_TRY(Rounded(elements));
  const std::vector<std::uint32_t> firsts = FirstsOfEqual(rounded);
  const std::vector<Area> areas = INTAGLIO_TRY(GrownAreas(rounded, firsts, options));
  std::vector<FlatBox> boxes;
  boxes.reserve(areas.size());
  for (const Area& area : areas) boxes.push_back({area.min_mm, area.max_mm});
  const auto pairs = INTAGLIO_TRY(NearPairsUpTo(boxes, kNear_mm, kMaxUnitedPairs));
  std::optional<Refusal> first;
  Progress progress(options.progress);
  for (const double tolerance : kTolerances_mm) {
    const Attempt attempt = TryTolerance(areas, pairs, tolerance, progress);
    if (progress.cancelled())
      return Fail(ErrorCode::kCancelled, "the union of the outlines was cancelled");
    if (!attempt.refusal) {
      progress.Report(kWork, kWork, 0, 1);
      Union result;
      for (const ChainedContour& chained : attempt.contours) {
        result.contours.push_back(MakeContour(areas, attempt.remains, chained));
        result.area_mm2 += result.contours.back().area_mm2;
      }
      NumberGroups(areas, attempt.groups, firsts, result);
      return result;
    }
    if (!first) first = attempt.refusal;
  }
  return Refuse(*first, rounded[areas[first->area].element]);
}

Edges Clockwise(const Contour& contour) {
  if (contour.inner) return contour.edges;
  Edges edges;
  for (auto edge = contour.edges.rbegin(); edge != contour.edges.rend(); ++edge)
    edges.push_back(Reversed(*edge));
  return edges;
}

}  // namespace intaglio::contour
