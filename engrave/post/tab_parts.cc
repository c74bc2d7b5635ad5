#include "engrave/post/tab_parts.h"

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::post {
namespace {

// Depths are sums of parts of the whole.
constexpr double kSameDepthMm = 1e-9;

bool IsDeeper(double depth_mm, double than_mm) {
  return depth_mm < than_mm - kSameDepthMm;
}

}  // namespace

bool HasTabs(const ToolPath& path) {
  return std::ranges::any_of(path.moves, &WorkMove::tab);
}

std::vector<PathPart> PartsOfPass(const ToolPath& path, const Cutting& cutting,
                                  std::size_t pass) {
  Require(pass < cutting.depths_mm.size(), "pass {} of {}", pass,
          cutting.depths_mm.size());
  const double depth_mm = cutting.depths_mm[pass];
  const std::optional<double>& top_mm = cutting.tab_top_mm;
  if (!HasTabs(path) || (top_mm && !IsDeeper(depth_mm, *top_mm)))
    return {{path, depth_mm}};
  const bool makes_tabs = top_mm && IsDeeper(*top_mm, 0) &&
                          (pass == 0 || IsDeeper(*top_mm, cutting.depths_mm[pass - 1]));
  std::vector<PathPart> parts;
  Vec2 at_mm = path.begin_mm;
  bool begins = true, before = false;
  for (const WorkMove& move : path.moves) {
    if (!move.tab || makes_tabs) {
      if (begins || move.tab != before)
        parts.push_back({{path.name, at_mm, {}}, move.tab ? *top_mm : depth_mm});
      parts.back().path.moves.push_back(move);
    }
    begins = move.tab && !makes_tabs;
    before = move.tab;
    at_mm = move.end_mm;
  }
  return parts;
}

}  // namespace intaglio::post
