#include "services/cli/contour/contour_project.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <variant>

namespace intaglio::cli {
namespace {

using contour::ProjectElement;
using contour::ProjectElementKind;

/// Places as nodes, one for each place in whole nanometres, as the file has them.
class NodeList {
 public:
  std::uint32_t Find(const Vec2& place_mm) {
    const std::pair key{std::llround(place_mm.x() * 1e6),
                        std::llround(place_mm.y() * 1e6)};
    const auto [found, added] =
        ids_.emplace(key, static_cast<std::uint32_t>(nodes_.size()));
    if (added) nodes_.push_back({found->second, place_mm});
    return found->second;
  }
  std::vector<contour::ProjectNode> Take() { return std::move(nodes_); }

 private:
  std::map<std::pair<long long, long long>, std::uint32_t> ids_;
  std::vector<contour::ProjectNode> nodes_;
};

std::optional<ProjectElement> ElementOfShape(const contour::Shape& shape,
                                             NodeList& nodes) {
  if (const auto* circle = std::get_if<contour::Circle>(&shape)) {
    return ProjectElement{ProjectElementKind::kRound, circle->diameter_mm,
                          nodes.Find(circle->center_mm), 0};
  }
  if (const auto* square = std::get_if<contour::Square>(&shape)) {
    return ProjectElement{ProjectElementKind::kSquare, square->side_mm,
                          nodes.Find(square->center_mm), 0};
  }
  if (const auto* octagon = std::get_if<contour::Octagon>(&shape)) {
    return ProjectElement{ProjectElementKind::kOctagon, octagon->size_mm,
                          nodes.Find(octagon->center_mm), 0};
  }
  if (const auto* track = std::get_if<contour::Track>(&shape)) {
    const std::uint32_t begin = nodes.Find(track->begin_mm);
    return ProjectElement{ProjectElementKind::kTrack, track->width_mm, begin,
                          nodes.Find(track->end_mm)};
  }
  return {};
}

}  // namespace

Result<contour::Project> ProjectOf(const CourseFiles& files) {
  contour::Project project;
  NodeList nodes;
  const auto add = [&](const ProjectElement& element) {
    project.root.groups.push_back({{element}, {}});
  };
  for (const contour::Element& element : files.elements) {
    const auto converted = ElementOfShape(element.shape, nodes);
    if (!converted) {
      return Fail(ErrorCode::kUnsupported,
                  fmt::format("--xml: {} is no element of a project, which has pads, "
                              "tracks and holes; leave --xml out",
                              contour::Describe(element)));
    }
    add(*converted);
  }
  if (!files.curves.empty()) {
    return Fail(ErrorCode::kUnsupported,
                "--xml: " + files.curves.front().name +
                    " is no element of a project, which has pads, tracks and holes; "
                    "leave --xml out");
  }
  for (const contour::Hole& hole : files.holes) {
    add({ProjectElementKind::kHole, hole.diameter_mm, nodes.Find(hole.center_mm), 0});
  }
  project.nodes = nodes.Take();
  return project;
}

}  // namespace intaglio::cli
