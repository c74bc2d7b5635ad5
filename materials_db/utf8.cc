// UTF-8 as in RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.

#include "materials_db/utf8.h"

#include "engrave/io/byte_order_mark.h"

namespace intaglio::materials_db {
namespace {

constexpr char32_t kReplacement = 0xFFFD;

struct Utf8Form {
  std::size_t length;
  char32_t first;  ///< the smallest character that may be written so
};

Utf8Form FormOf(unsigned char lead) {
  if (lead < 0x80) return {1, 0};
  if (lead >= 0xC2 && lead <= 0xDF) return {2, 0x80};
  if (lead >= 0xE0 && lead <= 0xEF) return {3, 0x800};
  if (lead >= 0xF0 && lead <= 0xF4) return {4, 0x10000};
  return {0, 0};
}

std::string FromUtf16(std::string_view bytes, bool big_endian) {
  const auto unit = [&](std::size_t i) {
    const auto a = static_cast<unsigned char>(bytes[i]);
    const auto b = static_cast<unsigned char>(bytes[i + 1]);
    return static_cast<char32_t>(big_endian ? a << 8 | b : b << 8 | a);
  };
  std::string text;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    char32_t c = unit(i);
    if (c >= 0xD800 && c <= 0xDBFF && i + 3 < bytes.size()) {
      const char32_t low = unit(i + 2);
      if (low >= 0xDC00 && low <= 0xDFFF) {
        c = 0x10000 + ((c - 0xD800) << 10) + (low - 0xDC00);
        i += 2;
      }
    }
    AppendUtf8(text, IsCharacter(c) ? c : kReplacement);
  }
  return text;
}

}  // namespace

void AppendUtf8(std::string& text, char32_t c) {
  const auto put = [&](char32_t byte) { text += static_cast<char>(byte); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | c >> 6);
    put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | c >> 12);
    put(0x80 | (c >> 6 & 0x3F));
    put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | c >> 18);
    put(0x80 | (c >> 12 & 0x3F));
    put(0x80 | (c >> 6 & 0x3F));
    put(0x80 | (c & 0x3F));
  }
}

bool IsUtf8(std::string_view bytes) {
  for (std::size_t i = 0; i < bytes.size();) {
    const auto lead = static_cast<unsigned char>(bytes[i]);
    const Utf8Form form = FormOf(lead);
    if (form.length == 0 || i + form.length > bytes.size()) return false;
    char32_t c = form.length == 1 ? lead : lead & (0x7Fu >> form.length);
    for (std::size_t k = 1; k < form.length; ++k) {
      const auto next = static_cast<unsigned char>(bytes[i + k]);
      if ((next & 0xC0) != 0x80) return false;
      c = c << 6 | (next & 0x3F);
    }
    if (c < form.first || !IsCharacter(c)) return false;
    i += form.length;
  }
  return true;
}

std::string ToUtf8(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE")) return FromUtf16(bytes, false);
  if (bytes.starts_with("\xFE\xFF")) return FromUtf16(bytes, true);
  bytes = io::WithoutByteOrderMark(bytes);
  if (IsUtf8(bytes)) return std::string(bytes);
  std::string text;
  for (const char c : bytes) AppendUtf8(text, static_cast<unsigned char>(c));
  return text;
}

}  // namespace intaglio::materials_db
