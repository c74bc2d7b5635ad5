#include <fmt/format.h>

#include <unordered_map>

#include "engrave/contour/files/project_file.h"
#include "engrave/core/check.h"

namespace intaglio::contour {
namespace {

constexpr int kIndent = 2;

void AppendLine(int depth, std::string_view line, std::string& text) {
  // Deep groups would be mostly blanks.
  text.append(static_cast<std::size_t>(kIndent * std::min(depth, 20)), ' ');
  text += line;
  text += '\n';
}

std::string NumberText(double value) {
  std::string text = fmt::format("{:.6f}", value);
  return text == "-0.000000" ? text.substr(1) : text;
}

std::string LineOf(const ProjectElement& e) {
  const char kind = static_cast<char>(e.kind);
  if (e.kind == ProjectElementKind::kTrack)
    return fmt::format("<element>{}|{}|{}|{}</element>", kind, NumberText(e.size_mm),
                       e.node, e.end_node);
  return fmt::format("<element>{}|{}|{}</element>", kind, NumberText(e.size_mm), e.node);
}

void AppendGroup(const ProjectGroup& group, int depth, std::string& text) {
  AppendLine(depth, "<group>", text);
  AppendLine(depth + 1, "<elements>", text);
  for (const ProjectElement& element : group.elements)
    AppendLine(depth + 2, LineOf(element), text);
  AppendLine(depth + 1, "</elements>", text);
  AppendLine(depth + 1, "<groups>", text);
  for (const ProjectGroup& inner : group.groups) AppendGroup(inner, depth + 2, text);
  AppendLine(depth + 1, "</groups>", text);
  AppendLine(depth, "</group>", text);
}

std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '\r')
      escaped += "&#13;";
    else
      escaped += c;
  }
  return escaped;
}

class BoardMaker {
 public:
  explicit BoardMaker(const Project& project) {
    for (const ProjectNode& node : project.nodes) places_[node.id] = node.place_mm;
    Add(project.root);
  }
  Board Take() { return std::move(board_); }

 private:
  const Vec2& Place(std::uint32_t id) const {
    const auto found = places_.find(id);
    Require(found != places_.end(), "an element is at node {}, which does not exist", id);
    return found->second;
  }

  void Add(const ProjectGroup& group) {
    for (const ProjectElement& e : group.elements) {
      const Vec2& place = Place(e.node);
      switch (e.kind) {
        case ProjectElementKind::kRound:
          board_.elements.push_back({Circle{place, e.size_mm}, {}});
          break;
        case ProjectElementKind::kSquare:
          board_.elements.push_back({Square{place, e.size_mm}, {}});
          break;
        case ProjectElementKind::kOctagon:
          board_.elements.push_back({Octagon{place, e.size_mm}, {}});
          break;
        case ProjectElementKind::kTrack:
          board_.elements.push_back({Track{place, Place(e.end_node), e.size_mm}, {}});
          break;
        case ProjectElementKind::kHole:
          board_.holes.push_back({place, e.size_mm});
          break;
      }
    }
    for (const ProjectGroup& inner : group.groups) Add(inner);
  }

  std::unordered_map<std::uint32_t, Vec2> places_;
  Board board_;
};

}  // namespace

std::string WriteProject(const Project& project) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<project>\n<settings>\n";
  for (const auto& [name, value] : project.settings)
    AppendLine(1, fmt::format("<{0}>{1}</{0}>", name, Escaped(value)), text);
  text += "</settings>\n<nodes>\n";
  for (const ProjectNode& node : project.nodes) {
    AppendLine(1,
               fmt::format("<node>{}|{}|{}</node>", node.id,
                           NumberText(node.place_mm.x()), NumberText(node.place_mm.y())),
               text);
  }
  text += "</nodes>\n";
  AppendGroup(project.root, 0, text);
  text += "</project>\n";
  return text;
}

Board BoardOf(const Project& project) { return BoardMaker(project).Take(); }

}  // namespace intaglio::contour
