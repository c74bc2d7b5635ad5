#include "engrave/contour/isolation.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "engrave/contour/gaps.h"
#include "engrave/contour/option_range.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A gap as wide as the tool but for the rounding of coordinates is wide enough.
constexpr double kRounding_mm = 2e-6;
// How much nearer the first pass runs where a gap is that wide: two contours with twice
// of this and the rounding between them are apart for Unite.
constexpr double kNearer_mm = 1e-5;
constexpr std::size_t kMaxNamed = 5;

Status CheckOptions(const IsolationOptions& options) {
  INTAGLIO_TRY(CheckOption("the tool's diameter", options.tool_diameter_mm, 0.001, 100));
  INTAGLIO_TRY(CheckOption("the number of passes", options.pass_count, 1, 20));
  // Below one half slivers may remain: see the header.
  return CheckOption("the overlap of passes", options.overlap_ratio, 0.5, 0.95);
}

std::string NameOf(const Element& element) {
  return element.name.empty() ? Describe(element) : element.name;
}

tl::unexpected<Error> RefuseGaps(std::span<const Element> elements,
                                 std::span<const Gap> gaps, double tool_mm) {
  std::string sentence;
  for (std::size_t k = 0; k < std::min(gaps.size(), kMaxNamed); ++k) {
    const Gap& gap = gaps[k];
    sentence += fmt::format(
        "{}cannot isolate {} from {}: gap {:.4g} < tool {:.4g} at ({:.4g}, {:.4g})",
        k == 0 ? "" : "; ", NameOf(elements[gap.first]), NameOf(elements[gap.second]),
        gap.width_mm, tool_mm, gap.place_mm.x(), gap.place_mm.y());
  }
  if (gaps.size() > kMaxNamed)
    sentence += fmt::format("; and {} more", gaps.size() - kMaxNamed);
  return Fail(
      ErrorCode::kUnsupported,
      sentence + fmt::format("; use a tool of {:.4g} mm or less, or move them apart",
                             gaps[0].width_mm),
      fmt::format("{:.6g}", gaps[0].width_mm));
}

/// The nets of groups of elements that touch. A group has the name that its elements have
/// in common, those without one aside; a group with two has none, as one without any.
class GroupNets {
 public:
  GroupNets(std::span<const Element> elements, const Union& copper)
      : groups_(copper.groups), nets_(copper.group_count) {
    std::vector<char> mixed(copper.group_count, 0);
    for (std::size_t k = 0; k < elements.size(); ++k) {
      std::string& net = nets_[groups_[k]];
      if (elements[k].net.empty()) continue;
      if (net.empty()) net = elements[k].net;
      if (net != elements[k].net) mixed[groups_[k]] = 1;
    }
    for (std::size_t group = 0; group < nets_.size(); ++group)
      if (mixed[group] != 0) nets_[group].clear();
  }
  /// Elements that need not be cut apart.
  bool AreOne(std::uint32_t a, std::uint32_t b) const {
    const std::string& net = nets_[groups_[a]];
    return groups_[a] == groups_[b] || (!net.empty() && net == nets_[groups_[b]]);
  }

 private:
  std::span<const std::uint32_t> groups_;
  std::vector<std::string> nets_;
};

/// How far the first pass runs from the copper, with gaps that are wide enough for it.
Result<double> FirstOffset(std::span<const Element> elements, const Union& copper,
                           const GroupNets& nets, double tool_mm) {
  auto gaps = INTAGLIO_TRY(NarrowGaps(elements, copper.groups, tool_mm + kNearer_mm));
  std::erase_if(gaps, [&](const Gap& gap) { return nets.AreOne(gap.first, gap.second); });
  if (gaps.empty()) return tool_mm / 2;
  std::erase_if(gaps,
                [&](const Gap& gap) { return gap.width_mm >= tool_mm - kRounding_mm; });
  if (!gaps.empty()) return RefuseGaps(elements, gaps, tool_mm);
  return tool_mm / 2 - kNearer_mm;
}

/// The sink of one of several unions that take about as long.
ProgressSink PartOf(const ProgressSink& whole, std::uint64_t number,
                    std::uint64_t count) {
  if (!whole) return {};
  return [&whole, number, count](std::uint64_t done, std::uint64_t total) {
    return whole(number * total + done, count * total);
  };
}

Status CheckPieces(std::span<const Element> elements, const GroupNets& nets,
                   const Union& grown) {
  std::vector<std::optional<std::uint32_t>> firsts(grown.group_count);
  for (std::uint32_t k = 0; k < elements.size(); ++k) {
    auto& first = firsts[grown.groups[k]];
    if (!first) first = k;
    if (nets.AreOne(k, *first)) continue;
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("cannot isolate {} from {}: the first pass leaves them in one "
                    "piece of copper; use a thinner tool, or move them apart",
                    NameOf(elements[*first]), NameOf(elements[k])));
  }
  return {};
}

}  // namespace

Result<Isolation> Isolate(std::span<const Element> elements,
                          const IsolationOptions& options) {
  INTAGLIO_TRY(CheckOptions(options));
  const std::vector<Element> rounded = INTAGLIO_TRY(Rounded(elements));
  const std::uint64_t unions = 1 + static_cast<std::uint64_t>(options.pass_count);
  const Union copper = INTAGLIO_TRY(
      Unite(rounded, {0, Corners::kRound, PartOf(options.progress, 0, unions)}));
  const GroupNets nets(rounded, copper);
  const double first_mm =
      INTAGLIO_TRY(FirstOffset(rounded, copper, nets, options.tool_diameter_mm));
  const double radius = options.tool_diameter_mm / 2;
  const double step = options.tool_diameter_mm * (1 - options.overlap_ratio);
  Isolation isolation;
  isolation.net_count = copper.group_count;
  for (int k = 0; k < options.pass_count; ++k) {
    const double offset = k == 0 ? first_mm : radius + k * step;
    const std::uint64_t number = 1 + static_cast<std::uint64_t>(k);
    Union grown = INTAGLIO_TRY(Unite(
        rounded, {offset, Corners::kRound, PartOf(options.progress, number, unions)}));
    if (k == 0) {
      INTAGLIO_TRY(CheckPieces(rounded, nets, grown));
      isolation.piece_count = grown.group_count;
    }
    isolation.passes.push_back({offset, std::move(grown.contours)});
    isolation.width_mm = radius + k * step + radius;
  }
  return isolation;
}

}  // namespace intaglio::contour
