#include "engrave/drawing/svg/svg_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_shapes.h"

namespace intaglio::drawing {
namespace {

using Entities = std::map<std::string, std::string, std::less<>>;

std::string_view NextToken(std::string_view& rest) {
  while (!rest.empty() && IsSvgBlank(rest.front())) rest.remove_prefix(1);
  const auto* const end = std::ranges::find_if(rest, IsSvgBlank);
  const std::string_view word(rest.begin(), end);
  rest.remove_prefix(word.size());
  return word;
}

/// The entities that the document type declares (XML 1.0, 4.2), `end`: behind it. Those
/// of other files are counted in `external`.
Entities EntitiesOf(std::string_view text, std::size_t& end, std::uint64_t& external) {
  Entities entities;
  const auto doctype = text.find("<!DOCTYPE");
  const auto inside =
      doctype == text.npos ? text.npos : text.find_first_of("[>", doctype);
  if (inside == text.npos || text[inside] != '[') return entities;
  end = text.find("]", inside);
  for (auto at = text.find("<!ENTITY", inside); at < end;
       at = text.find("<!ENTITY", at + 1)) {
    std::string_view rest = text.substr(at + std::string_view("<!ENTITY").size());
    const std::string name(NextToken(rest));
    const std::string_view value = text.substr(at);
    const auto open = value.find_first_of("\"'>");
    if (open == value.npos) break;
    const bool is_external = value.substr(0, open).find("SYSTEM") != value.npos ||
                             value.substr(0, open).find("PUBLIC") != value.npos;
    if (name == "%" || is_external || value[open] == '>') {
      ++external;
      continue;
    }
    const auto close = value.find(value[open], open + 1);
    if (close == value.npos) break;
    entities.try_emplace(name, value.substr(open + 1, close - open - 1));
    end = std::max(end, text.find("]", at + close));
    if (end == text.npos) end = text.size();
  }
  return entities;
}

/// The text with its references replaced once. Unknown ones stay as they are.
std::string Replaced(std::string_view text, const Entities& entities, std::size_t limit,
                     bool& any) {
  std::string replaced;
  any = false;
  while (!text.empty() && replaced.size() <= limit) {
    const auto mark = text.find('&');
    replaced += text.substr(0, mark);
    text.remove_prefix(std::min(text.size(), mark));
    if (text.empty()) break;
    const auto end = text.substr(0, 256).find(';');
    const auto found =
        end == text.npos ? entities.end() : entities.find(text.substr(1, end - 1));
    if (found == entities.end()) {
      replaced += '&';
      text.remove_prefix(1);
      continue;
    }
    replaced += found->second;
    text.remove_prefix(end + 1);
    any = true;
  }
  return replaced;
}

}  // namespace

bool SvgDocument::Load() {
  if (!CheckSize() || !Expand() || !CheckSize() || !Parse()) return false;
  if (SvgName(root().name()) != "svg") {
    return builder_.Refuse(ErrorCode::kUnreadable, "",
                           "the file has no svg element; it is not SVG", root().name());
  }
  return NoteIdsAndSheets();
}

/// Checked before parsing: the tree takes 64 bytes for an "<a>" in the file.
bool SvgDocument::CheckSize() {
  const DrawingLimits& limits = builder_.limits();
  if (!builder_.CheckSize(text_.size())) return false;
  std::uint64_t elements = 0, attributes = 0;
  for (std::size_t i = 0; i < text_.size(); ++i) {
    if (text_[i] == '=') ++attributes;
    if (text_[i] == '<' && i + 1 < text_.size() && text_[i + 1] != '/') ++elements;
  }
  const std::uint64_t largest = limits.max_entities;
  if (elements <= largest && attributes <= 8 * largest) return true;
  return builder_.Refuse(ErrorCode::kTooLarge, "",
                         fmt::format("the file has more than {} elements or {} "
                                     "attributes; divide the drawing or raise the limit",
                                     largest, 8 * largest));
}

bool SvgDocument::Expand() {
  constexpr int kMaxDepth = 16;
  std::size_t end = 0;
  std::uint64_t external = 0;
  const Entities entities = EntitiesOf(text_, end, external);
  if (external > 0) {
    builder_.LeaveOut("entity of another file", Effect::kLost, LineAt(0));
  }
  if (entities.empty()) return true;
  const std::size_t limit = builder_.limits().max_file_bytes;
  std::string head(text_.substr(0, end)), body(text_.substr(std::min(end, text_.size())));
  bool any = true;
  for (int depth = 0; any; ++depth) {
    body = Replaced(body, entities, limit, any);
    if (depth <= kMaxDepth && body.size() + head.size() <= limit) continue;
    return builder_.Refuse(ErrorCode::kTooLarge, "DOCTYPE",
                           "its entities expand without end or beyond the limit of a "
                           "file; export the drawing without entities");
  }
  expanded_ = std::move(head) + body;
  text_ = expanded_;
  return true;
}

std::string SvgDocument::LineAt(std::ptrdiff_t offset) const {
  const auto stop = std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text_));
  return fmt::format("line {}",
                     std::count(text_.begin(), text_.begin() + stop, '\n') + 1);
}

std::string SvgDocument::PlaceOf(const pugi::xml_node& node) const {
  const char* id = node.attribute("id").value();
  std::string place =
      fmt::format("{}, {}", LineAt(node.offset_debug()), Shown(SvgName(node.name())));
  if (*id != '\0') place += fmt::format(" \"{}\"", Shown(id));
  return place;
}

bool SvgDocument::Parse() {
  const pugi::xml_parse_result parsed = document_.load_buffer(
      text_.data(), text_.size(),
      pugi::parse_minimal | pugi::parse_escapes | pugi::parse_cdata | pugi::parse_pi,
      pugi::encoding_auto);
  if (parsed) return true;
  return builder_.Refuse(parsed.status == pugi::status_out_of_memory
                             ? ErrorCode::kTooLarge
                             : ErrorCode::kUnreadable,
                         LineAt(parsed.offset),
                         fmt::format("not well-formed XML ({}); export the drawing again",
                                     parsed.description()));
}

/// The elements by their ids and the style sheets, which apply wherever in the file
/// they are. Without recursion, because files may be nested to any depth.
bool SvgDocument::NoteIdsAndSheets() {
  for (const pugi::xml_node node : document_.children()) {
    if (node.type() == pugi::node_pi && SvgName(node.name()) == "xml-stylesheet")
      builder_.LeaveOut("style sheet of another file", Effect::kChanged, PlaceOf(node));
  }
  const pugi::xml_node top = root();
  pugi::xml_node node = top;
  int depth = 0;
  while (true) {
    if (const char* id = node.attribute("id").value(); *id != '\0') {
      by_id_.try_emplace(id, node);
    }
    if (SvgName(node.name()) == "style" && !TakeSheet(node)) return false;
    if (node.first_child()) {
      node = node.first_child();
      if (++depth > builder_.limits().max_nesting) return RefuseDepth(node);
      continue;
    }
    while (node != top && !node.next_sibling()) {
      node = node.parent();
      --depth;
    }
    if (node == top) return true;
    node = node.next_sibling();
  }
}

bool SvgDocument::TakeSheet(const pugi::xml_node& node) {
  const std::string_view type = node.attribute("type").value();
  const std::string_view media = node.attribute("media").value();
  if ((!type.empty() && type != "text/css") ||
      (!media.empty() && media.find("all") == media.npos &&
       media.find("screen") == media.npos)) {
    builder_.LeaveOut("style sheet of another kind", Effect::kNothingSeen, PlaceOf(node));
    return true;
  }
  std::string css;
  for (const pugi::xml_node part : node.children()) css += part.value();
  return sheets_.AddSheet(css);
}

bool SvgDocument::RefuseDepth(const pugi::xml_node& node) {
  return builder_.Refuse(
      ErrorCode::kTooLarge, PlaceOf(node),
      fmt::format("elements or references are nested more than {} deep; ungroup them",
                  builder_.limits().max_nesting));
}

pugi::xml_node SvgDocument::Find(std::string_view reference) const {
  if (reference.starts_with("url(")) {
    reference = reference.substr(4, reference.find(')') - 4);
    while (!reference.empty() && (IsSvgBlank(reference.front()) ||
                                  reference.front() == '"' || reference.front() == '\''))
      reference.remove_prefix(1);
    while (!reference.empty() && (IsSvgBlank(reference.back()) ||
                                  reference.back() == '"' || reference.back() == '\''))
      reference.remove_suffix(1);
  }
  if (!reference.starts_with('#')) return {};
  const auto found = by_id_.find(reference.substr(1));
  return found == by_id_.end() ? pugi::xml_node() : found->second;
}

}  // namespace intaglio::drawing
