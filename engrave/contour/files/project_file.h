#pragma once

// Project files of the program of Siwiec 2016 (ch. 5.3): elements in groups that nest,
// with all positions in a list of nodes that elements share. Frame: drawing, mm.
//
//   <group>
//     <elements><element>1|1.800000|0</element></elements>
//     <groups> <group>..</group> </groups>
//   </group>
//
// An element is 1|diameter|node (round pad), 2|side|node (square), 3|size|node (octagon),
// 4|width|node|node (track) or h|diameter|node (hole). Lists that are empty are written;
// numbers have six decimals. The source prints groups alone: it names the sections for
// settings and nodes ("ID, X, Y") without their tags. Those here are ours:
//
//   <project>
//     <settings> <NAME>text</NAME> .. </settings>
//     <nodes> <node>0|2.540000|2.540000</node> .. </nodes>
//     <group>..</group>
//   </project>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

enum class ProjectElementKind : char {
  kRound = '1',
  kSquare = '2',
  kOctagon = '3',
  kTrack = '4',
  kHole = 'h',
};

struct ProjectElement {
  ProjectElementKind kind = ProjectElementKind::kRound;
  double size_mm = 0;
  std::uint32_t node = 0;
  std::uint32_t end_node = 0;  ///< of a track

  bool operator==(const ProjectElement&) const = default;
};

struct ProjectGroup {
  std::vector<ProjectElement> elements;
  std::vector<ProjectGroup> groups;

  bool operator==(const ProjectGroup&) const = default;
};

struct ProjectNode {
  std::uint32_t id = 0;
  Vec2 place_mm = Vec2::Zero();

  bool operator==(const ProjectNode&) const = default;
};

struct Project {
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and text
  std::vector<ProjectNode> nodes;
  ProjectGroup root;

  bool operator==(const Project&) const = default;
};

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct ProjectLimits {
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::uint64_t max_elements = 1'000'000;
  std::uint64_t max_nodes = 1'000'000;
  int max_nesting = 1000;
};

/// Errors name the file, the line and the remedy: kUnreadable (no XML, an unknown tag, an
/// element that is none), kInvalidValue (a number), kMissing (a section, a node that an
/// element names: the published program leaves such an element out), kTooLarge.
Result<Project> ReadProject(std::string_view text, std::string_view name,
                            const ProjectLimits& limits = {});

/// What ReadProject gives back, but for sizes and places: rounded to 1 nm. Written, read
/// and written again the text is the same.
std::string WriteProject(const Project& project);

struct Board {
  std::vector<Element> elements;
  std::vector<Hole> holes;
};

/// In the order of the file, groups behind the elements of their parent. The nodes exist,
/// as ReadProject checks.
Board BoardOf(const Project& project);

}  // namespace intaglio::contour
