#include "engrave/drawing/svg/svg_style.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_shapes.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

// In the order of SvgProperty.
constexpr std::string_view kProperties[] = {"display",
                                            "visibility",
                                            "stroke",
                                            "fill",
                                            "clip-path",
                                            "clip-rule",
                                            "mask",
                                            "filter",
                                            "marker",
                                            "marker-start",
                                            "marker-mid",
                                            "marker-end",
                                            "overflow",
                                            "font-size",
                                            "opacity",
                                            "fill-opacity",
                                            "stroke-opacity",
                                            "stroke-dasharray",
                                            "transform",
                                            "transform-origin",
                                            "transform-box",
                                            "translate",
                                            "rotate",
                                            "scale",
                                            "offset-path",
                                            "zoom",
                                            "x",
                                            "y",
                                            "width",
                                            "height",
                                            "cx",
                                            "cy",
                                            "r",
                                            "rx",
                                            "ry",
                                            "d"};
static_assert(std::size(kProperties) == static_cast<std::size_t>(SvgProperty::kCount));
// Before it, attributes take part in the cascade.
constexpr auto kFirstOfCssAlone = static_cast<std::size_t>(SvgProperty::kTransform);
constexpr std::size_t kMaxValueBytes = 255;
constexpr std::size_t kMaxSelectorBytes = 1000;
// A rule takes ten times the memory of an element.
constexpr std::uint64_t kEntitiesPerSelector = 10;

// A rank, from its highest bit: !important; the style attribute; specificity as id,
// number of classes, element; the order in the file. Presentation attributes have 0.
constexpr std::uint64_t kImportant = std::uint64_t{1} << 62;
constexpr std::uint64_t kStyleAttribute = std::uint64_t{1} << 61;
constexpr std::uint64_t kId = std::uint64_t{1} << 60;
constexpr int kClassShift = 41;
constexpr std::uint64_t kMaxClasses = 1000;
constexpr std::uint64_t kElement = std::uint64_t{1} << 40;

bool IsNamePart(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         c == '-' || c == '_' || static_cast<unsigned char>(c) >= 0x80;
}
std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && IsSvgBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsSvgBlank(text.back())) text.remove_suffix(1);
  return text;
}
std::string Lower(std::string_view text) {
  return io::LowerCase(text.substr(0, kMaxValueBytes));
}

/// The end of the string that begins here.
std::size_t PastString(std::string_view css, std::size_t at) {
  const char quote = css[at];
  for (++at; at < css.size() && css[at] != quote; ++at) {
    if (css[at] == '\\') ++at;
  }
  return std::min(at + 1, css.size());
}

/// The position of the first stop character outside strings and brackets; the end when
/// there is none.
std::size_t EndOf(std::string_view css, std::string_view stops) {
  std::size_t at = 0, depth = 0;
  while (at < css.size()) {
    const char c = css[at];
    if (depth == 0 && stops.find(c) != stops.npos) return at;
    if (c == '"' || c == '\'') {
      at = PastString(css, at);
      continue;
    }
    if (c == '(' || c == '[' || c == '{') ++depth;
    if ((c == ')' || c == ']' || c == '}') && depth > 0) --depth;
    at += c == '\\' ? 2 : 1;
  }
  return css.size();
}

/// The text before the first stop character; `rest` then begins behind it.
std::string_view Cut(std::string_view& rest, std::string_view stops) {
  const std::size_t end = EndOf(rest, stops);
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(rest.size(), end + 1));
  return part;
}

/// Of an opacity: "0", ".0", "0%".
bool IsZero(std::string_view text) {
  if (text.ends_with('%')) text.remove_suffix(1);
  const bool has_digit = text.find('0') != text.npos;
  return has_digit && text.find_first_not_of("0.+-") == text.npos;
}

/// Whether a rule is about printing, fonts and time, or about what is drawn.
Effect EffectOfAtRule(std::string_view name) {
  constexpr std::string_view kChange[] = {"@media", "@import", "@supports", "@layer"};
  return std::ranges::find(kChange, name) == std::end(kChange) ? Effect::kNothingSeen
                                                               : Effect::kChanged;
}

/// Comments as blanks.
std::string WithoutComments(std::string_view css) {
  std::string plain;
  plain.reserve(css.size());
  std::size_t at = 0;
  while (at < css.size()) {
    std::size_t next = at + 1;
    if (css[at] == '"' || css[at] == '\'') {
      next = PastString(css, at);
    } else if (css.substr(at, 2) == "/*") {
      const auto end = css.find("*/", at + 2);
      at = end == css.npos ? css.size() : end + 2;
      plain += ' ';
      continue;
    }
    plain += css.substr(at, next - at);
    at = next;
  }
  return plain;
}

}  // namespace

bool SvgStyleSheets::AddSheet(std::string_view css) {
  const std::string plain = WithoutComments(css);
  std::string_view rest = plain;
  while (true) {
    rest = Trimmed(rest);
    if (rest.empty()) return true;
    // Marks that hid sheets from browsers without CSS.
    if (rest.starts_with("<!--") || rest.starts_with("-->")) {
      rest.remove_prefix(rest.front() == '<' ? 4 : 3);
    } else if (rest.front() == '@') {
      const auto name = std::find_if_not(rest.begin() + 1, rest.end(), IsNamePart);
      // Their rules may hide or shift what is drawn.
      builder_.LeaveOut({rest.begin(), name}, EffectOfAtRule({rest.begin(), name}));
      const std::size_t end = EndOf(rest, "{;");
      const bool has_block = end < rest.size() && rest[end] == '{';
      rest.remove_prefix(std::min(rest.size(), end + 1));
      if (has_block) Cut(rest, "}");
    } else {
      const std::string_view selectors = Cut(rest, "{");
      if (!AddRule(selectors, Cut(rest, "}"))) return false;
    }
  }
}

bool SvgStyleSheets::AddRule(std::string_view selectors, std::string_view block) {
  Declarations declarations;
  if (!Declare(block, selector_count_ + 1, declarations)) return true;
  while (!selectors.empty()) {
    const std::uint64_t largest = builder_.limits().max_entities / kEntitiesPerSelector;
    if (++selector_count_ > largest) {
      return builder_.Refuse(ErrorCode::kTooLarge, "style",
                             fmt::format("the sheets have more than {} selectors; "
                                         "export the drawing without style sheets",
                                         largest));
    }
    const auto selector = SelectorOf(Trimmed(Cut(selectors, ",")));
    if (!selector) {
      builder_.LeaveOut("style rule not by class, id or element", Effect::kChanged);
      continue;
    }
    const std::uint64_t specificity =
        (selector->id.empty() ? 0 : kId) + (selector->element.empty() ? 0 : kElement) +
        (std::min<std::uint64_t>(selector->classes.size(), kMaxClasses) << kClassShift);
    Declarations ranked = declarations;
    for (auto& declared : ranked) {
      if (declared) declared->rank += specificity;
    }
    Prefer(ranked, RuleOf(*selector).declarations);
  }
  return true;
}

std::optional<SvgStyleSheets::Selector> SvgStyleSheets::SelectorOf(
    std::string_view text) {
  if (text.empty() || text.size() > kMaxSelectorBytes) return std::nullopt;
  Selector selector;
  bool first = true;
  while (!text.empty()) {
    const char mark = text.front();
    const bool marked = mark == '.' || mark == '#';
    if (marked || (first && mark == '*')) text.remove_prefix(1);
    const auto end = std::find_if_not(text.begin(), text.end(), IsNamePart);
    const std::string name(text.begin(), end);
    text.remove_prefix(name.size());
    const bool any = first && mark == '*';
    if (name.empty() != any || (!marked && !first)) return std::nullopt;
    if (mark == '#' && !selector.id.empty()) return std::nullopt;
    if (mark == '.') selector.classes.push_back(name);
    if (mark == '#') selector.id = name;
    if (!marked && !any) selector.element = name;
    first = false;
  }
  std::ranges::sort(selector.classes);
  return selector;
}

bool SvgStyleSheets::Declare(std::string_view block, std::uint64_t rank,
                             Declarations& declarations) {
  bool any = false;
  while (!block.empty()) {
    std::string_view part = Cut(block, ";");
    const auto colon = part.find(':');
    if (colon == part.npos) continue;
    const std::string property = Lower(Trimmed(part.substr(0, colon)));
    const auto* const known = std::ranges::find(kProperties, property);
    if (known == std::end(kProperties)) continue;
    std::string_view value = Trimmed(part.substr(colon + 1));
    const auto mark = value.rfind('!');
    const bool important =
        mark != value.npos && Lower(Trimmed(value.substr(mark + 1))) == "important";
    if (important) value = Trimmed(value.substr(0, mark));
    if (value.empty()) continue;
    const std::uint64_t own_rank = rank + (important ? kImportant : 0);
    auto& declared = declarations[static_cast<std::size_t>(known - kProperties)];
    if (!declared || own_rank >= declared->rank) {
      declared = {std::string(value.substr(0, kMaxValueBytes)), own_rank};
    }
    any = true;
  }
  return any;
}

void SvgStyleSheets::Prefer(const Declarations& from, Declarations& winners) {
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from[i] && (!winners[i] || from[i]->rank >= winners[i]->rank)) {
      winners[i] = from[i];
    }
  }
}

SvgStyleSheets::Rule& SvgStyleSheets::RuleOf(const Selector& selector) {
  std::string whole = selector.element + "#" + selector.id;
  for (const std::string& name : selector.classes) whole += "." + name;
  const auto [found, is_new] = rule_by_selector_.try_emplace(whole, rules_.size());
  if (is_new) {
    std::string key = selector.element;
    if (!selector.classes.empty()) key = "." + selector.classes.front();
    if (!selector.id.empty()) key = "#" + selector.id;
    rules_by_key_[key].push_back(rules_.size());
    rules_.push_back({selector, {}});
  }
  return rules_[found->second];
}

namespace {

/// Calls visit(name) for every class of the element.
template <typename Visit>
bool ForEachClass(std::string_view classes, const Visit& visit) {
  while (!(classes = Trimmed(classes)).empty()) {
    const auto end = std::ranges::find_if(classes, IsSvgBlank);
    const std::string_view name(classes.begin(), end);
    if (!visit(name)) return false;
    classes.remove_prefix(name.size());
  }
  return true;
}

bool HasClass(std::string_view classes, std::string_view wanted) {
  return !ForEachClass(classes, [&](std::string_view name) { return name != wanted; });
}

}  // namespace

bool SvgStyleSheets::CountCompared(std::uint64_t bytes) {
  compared_bytes_ += bytes;
  if (compared_bytes_ <= builder_.limits().max_unfolded_bytes) return true;
  return builder_.Refuse(ErrorCode::kTooLarge, "style",
                         "the rules of the style sheets apply to too many elements; "
                         "export the drawing without style sheets");
}

bool SvgStyleSheets::TakeFrom(std::string_view key, const pugi::xml_node& node,
                              Declarations& winners) {
  if (!CountCompared(8)) return false;
  const auto found = rules_by_key_.find(std::string(key));
  if (found == rules_by_key_.end()) return true;
  const std::string_view classes = node.attribute("class").value();
  for (const std::size_t i : found->second) {
    const Selector& selector = rules_[i].selector;
    if (!CountCompared(8 + selector.classes.size() * classes.size())) return false;
    const bool matches =
        (selector.element.empty() || selector.element == SvgName(node.name())) &&
        (selector.id.empty() || selector.id == node.attribute("id").value()) &&
        std::ranges::all_of(selector.classes, [&](const std::string& name) {
          return HasClass(classes, name);
        });
    if (matches) Prefer(rules_[i].declarations, winners);
  }
  return true;
}

bool SvgStyleSheets::StyleOf(const pugi::xml_node& node, SvgStyle& style) {
  Declarations winners;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    const auto* const last = std::begin(kProperties) + kFirstOfCssAlone;
    const auto* const known =
        std::find(std::begin(kProperties), last, std::string_view(attribute.name()));
    const std::string_view value = Trimmed(attribute.value());
    if (known == last || value.empty()) continue;
    winners[static_cast<std::size_t>(known - kProperties)] = {
        std::string(value.substr(0, kMaxValueBytes)), 0};
  }
  if (!rules_.empty()) {
    const std::string_view id = node.attribute("id").value();
    const auto take_class = [&](std::string_view name) {
      return TakeFrom("." + std::string(name), node, winners);
    };
    if (!TakeFrom("", node, winners) || !TakeFrom(SvgName(node.name()), node, winners) ||
        !ForEachClass(node.attribute("class").value(), take_class) ||
        (!id.empty() && !TakeFrom("#" + std::string(id), node, winners))) {
      return false;
    }
  }
  Declarations own;
  if (const std::string_view text = node.attribute("style").value(); !text.empty()) {
    Declare(WithoutComments(text), kStyleAttribute, own);
    Prefer(own, winners);
  }
  const auto value = [&](SvgProperty property) {
    const auto& winner = winners[static_cast<std::size_t>(property)];
    return winner ? winner->value : std::string();
  };
  style.displayed = Lower(value(SvgProperty::kDisplay)) != "none" &&
                    !IsZero(value(SvgProperty::kOpacity));
  const std::string visibility = Lower(value(SvgProperty::kVisibility));
  if (visibility == "hidden" || visibility == "collapse") style.hidden = true;
  if (visibility == "visible" || visibility == "initial") style.hidden = false;
  const auto inherited = [](const std::string& text) {
    return text == "inherit" || text == "unset" ? std::string() : text;
  };
  style.stroke = IsZero(value(SvgProperty::kStrokeOpacity))
                     ? "none"
                     : inherited(value(SvgProperty::kStroke));
  style.fill = IsZero(value(SvgProperty::kFillOpacity))
                   ? "none"
                   : inherited(value(SvgProperty::kFill));
  for (std::size_t i = 0; i < winners.size(); ++i) {
    if (winners[i]) style.values[i] = std::move(winners[i]->value);
  }
  return true;
}

std::string_view SvgStyle::Attribute(const pugi::xml_node& node, const char* name) const {
  const auto* const known = std::ranges::find(kProperties, name);
  if (known != std::end(kProperties)) {
    const std::string& set = values[static_cast<std::size_t>(known - kProperties)];
    if (!set.empty()) return set;
  }
  return node.attribute(name).value();
}

}  // namespace intaglio::drawing
