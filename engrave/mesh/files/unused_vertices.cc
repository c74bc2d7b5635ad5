#include "engrave/mesh/files/unused_vertices.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::mesh {

void AddUnusedVertices(std::span<const std::uint32_t> welded, FileFindings& findings) {
  const auto first = std::ranges::find(welded, kUnset);
  if (first == welded.end()) return;
  FileFinding finding;
  finding.what = "vertex that belongs to no face";
  finding.plural = "vertices that belong to no face";
  finding.where =
      fmt::format("vertex {} of {}", first - welded.begin() + 1, welded.size());
  finding.remedy = "check that no faces are missing in the file";
  finding.count = static_cast<std::uint64_t>(std::ranges::count(welded, kUnset));
  finding.effect = Effect::kLost;
  findings.Add(std::move(finding));
}

}  // namespace intaglio::mesh
