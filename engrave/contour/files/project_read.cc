#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <unordered_set>

#include "engrave/contour/files/project_file.h"
#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

constexpr double kMaxSize_mm = 10'000;

std::vector<std::string_view> FieldsOf(std::string_view text) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t bar = text.find('|', begin);
    fields.push_back(text.substr(begin, bar - begin));
    if (bar == std::string_view::npos || fields.size() > 4) return fields;
    begin = bar + 1;
  }
}

class ProjectReader {
 public:
  ProjectReader(std::string_view text, std::string_view name, const ProjectLimits& limits)
      : text_(text), name_(name), limits_(limits) {}

  /// The only element at the top.
  Result<pugi::xml_node> Root(const char* tag) {
    if (text_.size() > limits_.max_file_bytes)
      return Wrong(ErrorCode::kTooLarge, 0,
                   fmt::format("the file has {} bytes, the limit is {}; divide the board",
                               text_.size(), limits_.max_file_bytes));
    const auto parsed = document_.load_buffer(
        text_.data(), text_.size(), pugi::parse_default | pugi::parse_ws_pcdata_single);
    if (!parsed)
      return Wrong(
          ErrorCode::kUnreadable, parsed.offset,
          fmt::format("{}; the file is damaged or not XML", parsed.description()));
    const pugi::xml_node root = document_.document_element();
    if (std::string_view(root.name()) != tag)
      return Wrong(ErrorCode::kUnreadable, root.offset_debug(),
                   fmt::format("expected <{}>, got <{}>; the file is no project of "
                               "circuit boards",
                               tag, root.name()));
    return root;
  }

  Result<Project> ReadAll(const pugi::xml_node& root) {
    Project project;
    for (const pugi::xml_node& section : root.children()) {
      const std::string_view tag = section.name();
      if (section.type() != pugi::node_element) continue;
      if (tag == "settings")
        INTAGLIO_TRY(ReadSettings(section, project));
      else if (tag == "nodes")
        INTAGLIO_TRY(ReadNodes(section, project));
      else if (tag != "group")
        return UnknownTag(section);
    }
    const pugi::xml_node group = root.child("group");
    if (!group || group.next_sibling("group"))
      return Wrong(
          ErrorCode::kMissing, root.offset_debug(),
          "a project has exactly one <group> besides its nodes; export it again");
    check_nodes_ = true;
    INTAGLIO_TRY(ReadGroup(group, project.root, 1));
    return project;
  }

  Status ReadGroup(const pugi::xml_node& node, ProjectGroup& group, int depth) {
    if (depth > limits_.max_nesting)
      return Wrong(
          ErrorCode::kTooLarge, node.offset_debug(),
          fmt::format("groups nest deeper than {}; ungroup some", limits_.max_nesting));
    for (const pugi::xml_node& list : node.children()) {
      if (list.type() != pugi::node_element) continue;
      const std::string_view tag = list.name();
      if (tag != "elements" && tag != "groups") return UnknownTag(list);
      for (const pugi::xml_node& item : list.children()) {
        if (item.type() != pugi::node_element) continue;
        if (tag == "elements" && std::string_view(item.name()) == "element") {
          group.elements.push_back(INTAGLIO_TRY(ReadElement(item)));
        } else if (tag == "groups" && std::string_view(item.name()) == "group") {
          group.groups.emplace_back();
          INTAGLIO_TRY(ReadGroup(item, group.groups.back(), depth + 1));
        } else {
          return UnknownTag(item);
        }
      }
    }
    return {};
  }

 private:
  tl::unexpected<Error> Wrong(ErrorCode code, std::ptrdiff_t offset,
                              const std::string& sentence,
                              std::string_view value = {}) const {
    const auto end =
        text_.begin() +
        std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(text_.size()));
    return Fail(code,
                fmt::format("{}: line {}: {}", name_,
                            1 + std::count(text_.begin(), end, '\n'), sentence),
                std::string(value.substr(0, 80)));
  }
  tl::unexpected<Error> UnknownTag(const pugi::xml_node& node) const {
    return Wrong(ErrorCode::kUnreadable, node.offset_debug(),
                 fmt::format("<{}> is not known here; export the project again",
                             std::string_view(node.name()).substr(0, 40)),
                 node.name());
  }

  Result<double> NumberIn(const pugi::xml_node& node, std::string_view text, double min) {
    const auto number = io::ParseFinite(text);
    if (number && *number >= min && *number <= kMaxSize_mm) return *number;
    return Wrong(
        ErrorCode::kInvalidValue, node.offset_debug(),
        fmt::format("expected a number of {} .. {} mm; correct it", min, kMaxSize_mm),
        text);
  }

  Result<std::uint32_t> IdIn(const pugi::xml_node& node, std::string_view text) {
    const auto number = io::ParseFinite(text);
    if (number && *number >= 0 && *number <= UINT32_MAX && *number == std::floor(*number))
      return static_cast<std::uint32_t>(*number);
    return Wrong(ErrorCode::kInvalidValue, node.offset_debug(),
                 "expected the number of a node; correct it", text);
  }

  Result<std::uint32_t> KnownNode(const pugi::xml_node& node, std::string_view text) {
    const std::uint32_t id = INTAGLIO_TRY(IdIn(node, text));
    if (!check_nodes_ || ids_.contains(id)) return id;
    return Wrong(ErrorCode::kMissing, node.offset_debug(),
                 fmt::format("the element is at node {}, which does not exist; add the "
                             "node or remove the element",
                             id),
                 text);
  }

  Result<ProjectElement> ReadElement(const pugi::xml_node& node) {
    if (++element_count_ > limits_.max_elements)
      return Wrong(
          ErrorCode::kTooLarge, node.offset_debug(),
          fmt::format("more than {} elements; divide the board", limits_.max_elements));
    const auto fields = FieldsOf(node.child_value());
    const std::string_view kind = fields[0];
    const bool track = kind == "4";
    if (kind.size() != 1 ||
        std::string_view("1234h").find(kind) == std::string_view::npos ||
        fields.size() != (track ? 4U : 3U))
      return Wrong(
          ErrorCode::kUnreadable, node.offset_debug(),
          "expected an element such as 1|1.8|0, 4|0.4|0|1 or h|1.0|0; correct it",
          node.child_value());
    ProjectElement element;
    element.kind = static_cast<ProjectElementKind>(kind[0]);
    element.size_mm = INTAGLIO_TRY(NumberIn(node, fields[1], 0));
    element.node = INTAGLIO_TRY(KnownNode(node, fields[2]));
    if (track) element.end_node = INTAGLIO_TRY(KnownNode(node, fields[3]));
    return element;
  }

  Status ReadNodes(const pugi::xml_node& section, Project& project) {
    for (const pugi::xml_node& node : section.children()) {
      if (node.type() != pugi::node_element) continue;
      if (std::string_view(node.name()) != "node") return UnknownTag(node);
      const auto fields = FieldsOf(node.child_value());
      if (fields.size() != 3)
        return Wrong(ErrorCode::kUnreadable, node.offset_debug(),
                     "expected a node such as 0|2.54|2.54; correct it",
                     node.child_value());
      const std::uint32_t id = INTAGLIO_TRY(IdIn(node, fields[0]));
      const double x = INTAGLIO_TRY(NumberIn(node, fields[1], -kMaxSize_mm));
      const double y = INTAGLIO_TRY(NumberIn(node, fields[2], -kMaxSize_mm));
      if (!ids_.insert(id).second)
        return Wrong(ErrorCode::kInvalidValue, node.offset_debug(),
                     fmt::format("node {} exists already; number the nodes anew", id),
                     fields[0]);
      if (ids_.size() > limits_.max_nodes)
        return Wrong(
            ErrorCode::kTooLarge, node.offset_debug(),
            fmt::format("more than {} nodes; divide the board", limits_.max_nodes));
      project.nodes.push_back({id, Vec2(x, y)});
    }
    return {};
  }

  Status ReadSettings(const pugi::xml_node& section, Project& project) {
    for (const pugi::xml_node& node : section.children()) {
      if (node.type() != pugi::node_element) continue;
      for (const pugi::xml_node& child : node.children()) {
        if (child.type() == pugi::node_element) return UnknownTag(child);
      }
      project.settings.emplace_back(node.name(), node.child_value());
    }
    return {};
  }

  std::string_view text_;
  std::string_view name_;
  ProjectLimits limits_;
  pugi::xml_document document_;
  std::unordered_set<std::uint32_t> ids_;
  std::uint64_t element_count_ = 0;
  bool check_nodes_ = false;
};

}  // namespace

Result<Project> ReadProject(std::string_view text, std::string_view name,
                            const ProjectLimits& limits) {
  ProjectReader reader(text, name, limits);
  const pugi::xml_node root = INTAGLIO_TRY(reader.Root("project"));
  return reader.ReadAll(root);
}

}  // namespace intaglio::contour
