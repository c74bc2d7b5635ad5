#include "engrave/drawing/utf8_characters.h"

#include <fmt/format.h>

#include <optional>

#include "engrave/drawing/drawing_builder.h"

namespace intaglio::drawing {
namespace {

/// The next character; none when the bytes are wrong.
std::optional<char32_t> NextCharacter(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if ((lead >= 0x80 && lead < 0xC2) || lead > 0xF4 || text.size() < length) {
    return std::nullopt;
  }
  char32_t code = length == 1 ? lead : lead & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xC0U) != 0x80) return std::nullopt;
    code = (code << 6) | (byte & 0x3FU);
  }
  constexpr char32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kMin[length] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) {
    return std::nullopt;
  }
  text.remove_prefix(length);
  return code;
}

}  // namespace

Result<std::u32string> CharactersOf(std::string_view utf8) {
  std::u32string characters;
  while (!utf8.empty()) {
    const auto next = NextCharacter(utf8);
    if (!next) {
      return Fail(ErrorCode::kUnreadable, "the text is not UTF-8; save it as UTF-8",
                  Shown(utf8));
    }
    characters.push_back(*next);
  }
  return characters;
}

std::string Utf8Of(std::u32string_view characters) {
  std::string utf8;
  for (const char32_t c : characters) {
    const auto tail = [&](int shift) {
      utf8 += static_cast<char>(0x80U | ((c >> shift) & 0x3FU));
    };
    if (c < 0x80) {
      utf8 += static_cast<char>(c);
    } else if (c < 0x800) {
      utf8 += static_cast<char>(0xC0U | (c >> 6));
      tail(0);
    } else if (c < 0x10000) {
      utf8 += static_cast<char>(0xE0U | (c >> 12));
      tail(6), tail(0);
    } else {
      utf8 += static_cast<char>(0xF0U | (c >> 18));
      tail(12), tail(6), tail(0);
    }
  }
  return utf8;
}

std::string NameOfCharacter(char32_t character) {
  const auto code = fmt::format("U+{:04X}", static_cast<std::uint32_t>(character));
  const bool control = character < 0x20 || (character >= 0x7F && character < 0xA0);
  // Marks that combine with a neighbour, and what only directs the text.
  const bool invisible = (character >= 0x300 && character < 0x370) ||
                         (character >= 0x200B && character < 0x2010) ||
                         (character >= 0xFE00 && character < 0xFE10);
  if (control || invisible) return code;
  return fmt::format("'{}' ({})", Utf8Of({&character, 1}), code);
}

}  // namespace intaglio::drawing
