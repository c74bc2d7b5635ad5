#include "services/job/files/json_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <regex>

namespace intaglio {
namespace {

// protobuf takes lower_case and camelCase names alike.
std::string Plain(std::string_view name) {
  std::string plain;
  for (const char c : name) {
    if (c != '_') plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

// Walks over a JSON text that may end or break anywhere.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {}

  // To the value of this member of the object ahead; returns the position of its name.
  std::optional<std::size_t> EnterMember(std::string_view name) {
    if (!Take('{')) return {};
    while (!Ahead('}') && !AtEnd()) {
      const std::size_t start = at_;
      const std::string_view found = TakeString();
      if (!Take(':')) return {};
      if (Plain(found) == Plain(name)) return start;
      SkipValue();
      if (!Take(',')) return {};
    }
    return {};
  }

  bool EnterElement(int index) {
    if (!Take('[')) return false;
    for (int i = 0; i < index; ++i) {
      SkipValue();
      if (!Take(',')) return false;
    }
    return true;
  }

 private:
  void SkipSpace() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])))
      ++at_;
  }
  bool AtEnd() const { return at_ >= text_.size(); }
  bool Ahead(char c) {
    SkipSpace();
    return !AtEnd() && text_[at_] == c;
  }
  bool Take(char c) {
    const bool there = Ahead(c);
    if (there) ++at_;
    SkipSpace();
    return there;
  }
  std::string_view TakeString() {
    if (!Ahead('"')) return {};
    const std::size_t start = ++at_;
    while (!AtEnd() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    const std::size_t end = std::min(at_, text_.size());
    at_ = std::min(end + 1, text_.size());
    return text_.substr(start, end - start);
  }
  // A whole value: brackets are counted, strings are stepped over.
  void SkipValue() {
    int depth = 0;
    SkipSpace();
    while (!AtEnd()) {
      const char c = text_[at_];
      if (depth == 0 && (c == ',' || c == '}' || c == ']')) return;
      if (c == '"') {
        TakeString();
        continue;
      }
      if (c == '{' || c == '[') ++depth;
      if (c == '}' || c == ']') --depth;
      ++at_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// Path as in "models[1].placement.unit_mm".
std::optional<std::size_t> FindPath(std::string_view text, const std::string& path) {
  static const std::regex kStep(R"(([A-Za-z0-9_]+)(?:\[(\d{1,6})\])?)");
  Walker walker(text);
  std::optional<std::size_t> found;
  for (auto it = std::sregex_iterator(path.begin(), path.end(), kStep);
       it != std::sregex_iterator(); ++it) {
    const auto member = walker.EnterMember((*it)[1].str());
    if (!member) return found;
    found = member;
    if ((*it)[2].matched && !walker.EnterElement(std::stoi((*it)[2].str()))) return found;
  }
  return found;
}

// An excerpt of up to 20 characters to each side and a line with a caret below it.
std::optional<std::size_t> FindExcerpt(std::string_view text, std::string_view message,
                                       std::string_view& what) {
  const std::size_t first = message.find('\n');
  const std::size_t last = message.rfind('\n');
  if (first == std::string_view::npos || last <= first || message.back() != '^')
    return {};
  const std::string_view excerpt = message.substr(first + 1, last - first - 1);
  what = message.substr(0, first);
  const std::size_t place = text.find(excerpt);
  // Twice the same: it is ambiguous which one is meant.
  if (place == std::string_view::npos || text.find(excerpt, place + 1) != text.npos)
    return {};
  return place + (message.size() - 1 - (last + 1));
}

std::string WithPosition(std::string_view text, std::size_t place,
                         std::string_view what) {
  const std::string_view before = text.substr(0, std::min(place, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  return fmt::format("{}:{}: {}", line, before.size() - line_start + 1, what);
}

}  // namespace

std::string LocateJsonError(std::string_view text, const std::string& parser_message) {
  std::string_view what = parser_message;
  std::optional<std::size_t> place = FindExcerpt(text, parser_message, what);
  static const std::regex kField(R"(^(?:\(([^)]*)\))?:? ?([A-Za-z0-9_]+)?: )");
  std::smatch match;
  if (!place && std::regex_search(parser_message, match, kField)) {
    const std::string member = match[2].str();
    place = FindPath(text, match[1].str() + (member.empty() ? "" : "." + member));
  }
  return place ? WithPosition(text, *place, what) : fmt::format(" {}", what);
}

}  // namespace intaglio
