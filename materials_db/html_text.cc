#include "materials_db/html_text.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <utility>

#include "engrave/io/lower_case.h"
#include "materials_db/utf8.h"

namespace intaglio::materials_db {
namespace {

constexpr std::size_t kMaxEntityBytes = 10;

struct Entity {
  std::string_view name;
  char32_t character;
};

constexpr std::array kEntities = {
    Entity{"amp", '&'},      Entity{"lt", '<'},       Entity{"gt", '>'},
    Entity{"quot", '"'},     Entity{"apos", '\''},    Entity{"nbsp", ' '},
    Entity{"ndash", 0x2013}, Entity{"mdash", 0x2014}, Entity{"deg", 0xB0},
    Entity{"micro", 0xB5},   Entity{"times", 0xD7},   Entity{"middot", 0xB7},
};

bool IsHtmlSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// The character of an entity, given without its & and ;.
std::optional<char32_t> EntityCharacter(std::string_view name) {
  for (const auto& [known, c] : kEntities) {
    if (name == known) return c;
  }
  if (name.size() < 2 || name[0] != '#') return std::nullopt;
  name.remove_prefix(1);
  const bool hex = name[0] == 'x' || name[0] == 'X';
  if (hex) name.remove_prefix(1);
  std::uint32_t c = 0;
  const auto [end, error] =
      std::from_chars(name.data(), name.data() + name.size(), c, hex ? 16 : 10);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  if (c == 0 || !IsCharacter(c)) return std::nullopt;
  return c;
}

/// Plain text that grows; white space of the HTML is added only when text precedes and
/// follows it on the same line.
class PlainText {
 public:
  void Space() { space_ = true; }
  void Line() {
    text_ += '\n';
    at_line_start_ = true;
    space_ = false;
  }
  void Character(char32_t c) {
    if (space_ && !at_line_start_) text_ += ' ';
    space_ = false;
    at_line_start_ = false;
    AppendUtf8(text_, c);
  }
  void Byte(char byte) {
    if (space_ && !at_line_start_) text_ += ' ';
    space_ = false;
    at_line_start_ = false;
    text_ += byte;
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
  bool space_ = false;
  bool at_line_start_ = true;
};

bool BreaksLine(std::string_view tag) {
  std::string name;
  for (const char c : tag) {
    if (!io::IsLetter(c)) break;
    name += static_cast<char>(c | 0x20);
  }
  return name == "br" || name == "p";
}

}  // namespace

std::string TextFromHtml(std::string_view html) {
  PlainText text;
  for (std::size_t i = 0; i < html.size(); ++i) {
    const char c = html[i];
    const std::string_view rest = html.substr(i + 1);
    if (c == '<' && !rest.empty() && (io::IsLetter(rest[0]) || rest[0] == '/')) {
      const std::size_t end = rest.find('>');
      if (end != std::string_view::npos) {
        if (BreaksLine(rest.substr(0, end))) text.Line();
        i += end + 1;
        continue;
      }
    }
    if (c == '&') {
      const std::size_t end = rest.substr(0, kMaxEntityBytes).find(';');
      if (end != std::string_view::npos) {
        if (const auto entity = EntityCharacter(rest.substr(0, end))) {
          text.Character(*entity);
          i += end + 1;
          continue;
        }
      }
    }
    if (IsHtmlSpace(c)) {
      text.Space();
    } else {
      text.Byte(c);
    }
  }
  return text.Take();
}

std::string HtmlFromText(std::string_view text) {
  std::string html;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool at_end = i == 0 || i + 1 == text.size() || IsHtmlSpace(text[i - 1]) ||
                        IsHtmlSpace(text[i + 1]);
    if (c == '\n') {
      html += "<br>";
    } else if (c == '&') {
      html += "&amp;";
    } else if (c == '<') {
      html += "&lt;";
    } else if (c == '>') {
      html += "&gt;";
    } else if (c == ' ' && at_end) {
      html += "&#32;";
    } else if (c == '\t') {
      html += "&#9;";
    } else if (c == '\r') {
      html += "&#13;";
    } else {
      html += c;
    }
  }
  return html;
}

}  // namespace intaglio::materials_db
