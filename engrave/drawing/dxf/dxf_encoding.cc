#include "engrave/drawing/dxf/dxf_encoding.h"

#include <fmt/format.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

using namespace std::string_view_literals;

constexpr auto kSentinel = "AutoCAD Binary DXF\r\n\x1A\0"sv;

enum class ValueType { kText, kDouble, kInt16, kInt32, kInt64, kBool, kBytes, kUnknown };

/// DXF reference, "Group code value types".
ValueType TypeOf(int code) {
  const auto in = [code](int low, int high) { return code >= low && code <= high; };
  if (in(10, 59) || in(110, 149) || in(210, 239) || in(460, 469) || in(1010, 1059))
    return ValueType::kDouble;
  if (in(60, 79) || in(170, 179) || in(270, 289) || in(370, 389) || in(400, 409) ||
      in(1060, 1070))
    return ValueType::kInt16;
  if (in(90, 99) || in(420, 429) || in(440, 459) || code == 1071)
    return ValueType::kInt32;
  if (in(160, 169)) return ValueType::kInt64;
  if (in(290, 299)) return ValueType::kBool;
  if (in(310, 319) || code == 1004) return ValueType::kBytes;
  if (in(0, 9) || in(100, 109) || in(300, 369) || in(390, 399) || in(410, 419) ||
      in(430, 439) || in(470, 481) || in(999, 1009))
    return ValueType::kText;
  return ValueType::kUnknown;
}

class BinaryReader {
 public:
  explicit BinaryReader(std::string_view rest) : rest_(rest) {
    // Before release 13 a code is one byte, then two: the first group is 0, SECTION.
    wide_ = rest_.size() > 1 && rest_[1] == '\0';
  }

  bool at_end() const { return rest_.empty(); }

  std::optional<int> Code() {
    if (wide_) return Number<std::int16_t>();
    const auto code = Number<std::uint8_t>();
    if (code && *code == 255) return Number<std::int16_t>();
    return code;
  }

  /// Nothing when the file ends within it.
  std::optional<std::string> Value(int code) {
    switch (TypeOf(code)) {
      case ValueType::kDouble:
        return ShownNumber<double>();
      case ValueType::kInt16:
        return ShownNumber<std::int16_t>();
      case ValueType::kInt32:
        return ShownNumber<std::int32_t>();
      case ValueType::kInt64:
        return ShownNumber<std::int64_t>();
      case ValueType::kBool:
        return ShownNumber<std::int8_t>();
      case ValueType::kBytes: {
        const auto size = Number<std::uint8_t>();
        if (!size || rest_.size() < *size) return std::nullopt;
        rest_.remove_prefix(*size);
        return std::string();
      }
      case ValueType::kText:
        return Text();
      case ValueType::kUnknown:
        break;
    }
    return std::nullopt;
  }

 private:
  template <typename T>
  std::optional<T> Number() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    T number{};
    std::memcpy(&number, rest_.data(), sizeof number);
    rest_.remove_prefix(sizeof number);
    return number;
  }
  template <typename T>
  std::optional<std::string> ShownNumber() {
    const std::optional<T> number = Number<T>();
    return number.has_value() ? std::optional(fmt::format("{}", number.value()))
                              : std::nullopt;
  }
  std::optional<std::string> Text() {
    const auto end = rest_.find('\0');
    if (end == rest_.npos) return std::nullopt;
    std::string text(rest_.substr(0, end));
    for (char& c : text) {
      if (c == '\n' || c == '\r') c = ' ';
    }
    rest_.remove_prefix(end + 1);
    return text;
  }

  std::string_view rest_;
  bool wide_ = false;
};

/// Line by line, so that a large file is not copied.
bool IsUtf8(std::string_view file) {
  while (!file.empty()) {
    const std::string_view line = file.substr(0, file.find('\n'));
    const bool ascii = std::ranges::all_of(
        line, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    if (!ascii && !CharactersOf(line)) return false;
    file.remove_prefix(std::min(file.size(), line.size() + 1));
  }
  return true;
}

/// Bytes that the code page does not have become "?".
void AppendConverted(std::string_view line, iconv_t converter, std::string& text) {
  std::string source(line);
  char* from = source.data();
  std::size_t left = source.size();
  while (left > 0) {
    std::array<char, 256> buffer;
    char* to = buffer.data();
    std::size_t room = buffer.size();
    const bool whole = iconv(converter, &from, &left, &to, &room) != std::size_t(-1);
    text.append(buffer.data(), buffer.size() - room);
    if (whole || errno == E2BIG) continue;
    text += '?';
    ++from;
    --left;
  }
}

/// The value of the header's variable; empty: it is not there.
std::string_view HeaderText(std::string_view file, std::string_view variable) {
  const auto at = file.substr(0, file.find("ENDSEC")).find(variable);
  if (at == file.npos) return {};
  std::string_view rest = file.substr(at);
  for (int lines = 0; lines < 2; ++lines) {
    rest.remove_prefix(std::min(rest.size(), rest.find('\n')));
    if (!rest.empty()) rest.remove_prefix(1);
  }
  rest = rest.substr(0, rest.find_first_of("\r\n"));
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  while (!rest.empty() && rest.back() == ' ') rest.remove_suffix(1);
  return rest.substr(0, 32);
}

/// Names "ANSI_1252" or "dos850" as iconv does.
std::string NameForIconv(std::string_view code_page) {
  const auto digits = code_page.find_first_of("0123456789");
  if (digits == code_page.npos) return "CP1252";
  return "CP" + std::string(code_page.substr(digits));
}

}  // namespace

bool IsBinaryDxf(std::string_view file) { return file.starts_with(kSentinel); }

Result<std::string> TextOfBinaryDxf(std::string_view file, std::size_t max_bytes) {
  BinaryReader reader(file.substr(kSentinel.size()));
  std::string text;
  while (!reader.at_end()) {
    const std::optional<int> code = reader.Code();
    const auto value = code ? reader.Value(*code) : std::nullopt;
    if (!value) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("the binary DXF ends within a group, or group {} has no "
                              "known type; save it as DXF in text form",
                              code.value_or(0)));
    }
    text += fmt::format("{}\n{}\n", *code, *value);
    if (text.size() > max_bytes) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("the binary DXF is more than {} bytes as text; divide the "
                              "drawing or raise the limit",
                              max_bytes));
    }
    if (*code == 0 && *value == "EOF") break;
  }
  return text;
}

std::optional<std::string> DxfInUtf8(std::string_view file, std::string& code_page) {
  if (IsUtf8(file)) return std::string();
  code_page = std::string(HeaderText(file, "$DWGCODEPAGE"));
  if (code_page.empty()) return std::string();
  const iconv_t converter = iconv_open("UTF-8", NameForIconv(code_page).c_str());
  if (converter == reinterpret_cast<iconv_t>(-1)) return std::nullopt;
  std::string text;
  text.reserve(file.size() + file.size() / 8);
  while (!file.empty()) {
    const std::string_view line = file.substr(0, file.find('\n'));
    if (IsUtf8(line)) {
      text += line;
    } else {
      AppendConverted(line, converter, text);
    }
    file.remove_prefix(std::min(file.size(), line.size() + 1));
    text += '\n';
  }
  iconv_close(converter);
  return text;
}

}  // namespace intaglio::drawing
