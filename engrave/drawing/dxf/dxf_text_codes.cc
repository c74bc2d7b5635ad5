#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "engrave/drawing/dxf/dxf_text.h"

namespace intaglio::drawing {
namespace {

constexpr double kMinRatio = 0.01, kMaxRatio = 100;
constexpr std::size_t kMaxGroups = 64;

/// "\U+2205" at the front of the text.
std::optional<char32_t> TakeUnicode(std::u32string_view& text) {
  if (!text.starts_with(U"\\U+") || text.size() < 7) return std::nullopt;
  char32_t character = 0;
  for (const char32_t digit : text.substr(3, 4)) {
    const bool decimal = digit >= U'0' && digit <= U'9';
    const char32_t letter = digit | 0x20U;
    if (!decimal && (letter < U'a' || letter > U'f')) return std::nullopt;
    character = 16 * character + (decimal ? digit - U'0' : letter - U'a' + 10);
  }
  if (character == 0 || (character >= 0xD800 && character < 0xE000)) return std::nullopt;
  text.remove_prefix(7);
  return character;
}

/// "%%c" at the front; 0: a code without a letter.
std::optional<char32_t> TakePercent(std::u32string_view& text) {
  if (!text.starts_with(U"%%") || text.size() < 3) return std::nullopt;
  char32_t character = 0;
  std::size_t length = 3;
  switch (text[2] | 0x20U) {
    case U'c':
      character = U'\u2300';  // diameter
      break;
    case U'd':
      character = U'\u00B0';
      break;
    case U'p':
      character = U'\u00B1';
      break;
    case U'u':
    case U'o':
    case U'k':
      break;
    default:
      if (text[2] == U'%') {
        character = U'%';
        break;
      }
      for (length = 2; length < std::min<std::size_t>(5, text.size()); ++length) {
        if (text[length] < U'0' || text[length] > U'9') break;
        character = 10 * character + text[length] - U'0';
      }
      if (length != 5 || character < 32 || character > 126) return std::nullopt;
  }
  text.remove_prefix(length);
  return character;
}

/// What stands between a code's letter and its semicolon, which it removes.
std::u32string_view TakeArgument(std::u32string_view& text) {
  const auto end = text.find(U';');
  const std::u32string_view argument = text.substr(0, end);
  text.remove_prefix(end == text.npos ? text.size() : end + 1);
  return argument;
}

/// "2.5" or "1.5x"; nullopt: no number.
std::optional<double> MtextNumber(std::u32string_view argument, bool& relative) {
  std::string ascii;
  for (const char32_t c : argument) ascii.push_back(c < 128 ? static_cast<char>(c) : '?');
  relative = ascii.ends_with('x') || ascii.ends_with('X');
  if (relative) ascii.pop_back();
  return NumberOf(std::string_view(ascii));
}

class MtextReader {
 public:
  explicit MtextReader(std::u32string_view text) : rest_(text) {}

  std::vector<DxfTextLine> Read() {
    while (!rest_.empty()) {
      if (const auto character = TakeUnicode(rest_)) {
        Add(*character);
      } else if (const auto percent = TakePercent(rest_)) {
        if (*percent != 0) Add(*percent);
      } else {
        TakeNext();
      }
    }
    return std::move(lines_);
  }

 private:
  struct Form {
    double height = 1, width = 1;
    bool operator==(const Form&) const = default;
  };

  void Add(char32_t character) {
    DxfTextLine& line = lines_.back();
    if (line.empty() ||
        Form{line.back().height_ratio, line.back().width_ratio} != form_) {
      line.push_back({{}, form_.height, form_.width});
    }
    line.back().text.push_back(character);
  }

  char32_t Take() {
    const char32_t c = rest_.front();
    rest_.remove_prefix(1);
    return c;
  }

  void TakeNext() {
    const char32_t c = Take();
    if (c == U'\\' && !rest_.empty()) return TakeCode(Take());
    if (c == U'^' && !rest_.empty()) return TakeControl(Take());
    if (c == U'{') {
      if (outer_.size() < kMaxGroups) outer_.push_back(form_);
    } else if (c == U'}') {
      if (outer_.empty()) return;
      form_ = outer_.back();
      outer_.pop_back();
    } else {
      Add(c);
    }
  }

  /// "^I" is a tab, "^J" the end of a line, "^ " the letter itself.
  void TakeControl(char32_t c) {
    if (c == U'I') return Add(U' ');
    if (c == U'J') return lines_.emplace_back(), void();
    if (c == U' ') Add(U'^');
  }

  void TakeCode(char32_t code) {
    switch (code) {
      case U'P':
      case U'N':
      case U'X':
        lines_.emplace_back();
        return;
      case U'~':
        return Add(U'\u00A0');
      case U'L':
      case U'l':
      case U'O':
      case U'o':
      case U'K':
      case U'k':
        return;
      case U'H':
        return SetRatio(form_.height, true);
      case U'W':
        return SetRatio(form_.width, false);
      case U'S':
        return AddStack();
      case U'f':
      case U'F':
      case U'C':
      case U'c':
      case U'Q':
      case U'T':
      case U'A':
      case U'p':
        TakeArgument(rest_);
        return;
      default:
        Add(code);  // \\ \{ \}
    }
  }

  /// An absolute height is marked by its sign until the entity's own is known.
  void SetRatio(double& ratio, bool is_height) {
    bool relative = false;
    const auto number = MtextNumber(TakeArgument(rest_), relative);
    if (!number || !(*number > 0)) return;
    if (is_height && !relative) {
      ratio = -*number;
    } else {
      ratio = is_height ? ratio * std::clamp(*number, kMinRatio, kMaxRatio)
                        : std::clamp(*number, kMinRatio, kMaxRatio);
    }
  }

  /// "\S1/2;", "1^2", "1#2": in one line.
  void AddStack() {
    for (const char32_t c : TakeArgument(rest_)) {
      Add(c == U'^' || c == U'#' ? U'/' : c);
    }
  }

  std::u32string_view rest_;
  Form form_;
  std::vector<Form> outer_;
  std::vector<DxfTextLine> lines_{DxfTextLine()};
};

}  // namespace

std::u32string PlainDxfText(std::u32string_view text) {
  std::u32string plain;
  while (!text.empty()) {
    if (const auto character = TakeUnicode(text)) {
      plain.push_back(*character);
    } else if (const auto percent = TakePercent(text)) {
      if (*percent != 0) plain.push_back(*percent);
    } else {
      plain.push_back(text.front());
      text.remove_prefix(1);
    }
  }
  return plain;
}

std::vector<DxfTextLine> DxfMtextLines(std::u32string_view text) {
  return MtextReader(text).Read();
}

}  // namespace intaglio::drawing
