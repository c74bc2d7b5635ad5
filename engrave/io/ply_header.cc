#include "engrave/io/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

namespace intaglio::io {
namespace {

constexpr std::string_view kHeaderBlanks = " \t\r";

std::optional<PlyType> TypeNamed(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames = {{
      {"char", PlyType::kInt8},
      {"int8", PlyType::kInt8},
      {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},
      {"short", PlyType::kInt16},
      {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},
      {"uint16", PlyType::kUint16},
      {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},
      {"uint", PlyType::kUint32},
      {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat},
      {"float32", PlyType::kFloat},
      {"double", PlyType::kDouble},
      {"float64", PlyType::kDouble},
  }};
  for (const auto& [known, type] : kNames) {
    if (known == name) return type;
  }
  return std::nullopt;
}

std::vector<std::string_view> TokensOf(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kHeaderBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end =
        std::min(line.find_first_of(kHeaderBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kHeaderBlanks, end);
  }
  return words;
}

/// The text behind the first token and one blank.
std::string CommentOf(std::string_view line) {
  const std::size_t end = line.find_last_not_of('\r');
  line = line.substr(0, end == std::string_view::npos ? 0 : end + 1);
  const std::size_t blank = line.find_first_of(" \t");
  return blank == std::string_view::npos ? "" : std::string(line.substr(blank + 1));
}

bool ParseFormat(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3 || words[2] != "1.0") return false;
  if (words[1] == "ascii") {
    header.encoding = PlyEncoding::kAscii;
  } else if (words[1] == "binary_little_endian") {
    header.encoding = PlyEncoding::kLittleEndian;
  } else if (words[1] == "binary_big_endian") {
    header.encoding = PlyEncoding::kBigEndian;
  } else {
    return false;
  }
  return true;
}

bool ParseElement(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) return false;
  PlyElement element;
  element.name = words[1];
  const char* end = words[2].data() + words[2].size();
  const auto parsed = std::from_chars(words[2].data(), end, element.count);
  if (parsed.ptr != end) return false;
  if (parsed.ec == std::errc::result_out_of_range) {
    element.count = std::numeric_limits<std::uint64_t>::max();
  } else if (parsed.ec != std::errc()) {
    return false;
  }
  header.elements.push_back(std::move(element));
  return true;
}

bool ParseProperty(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (header.elements.empty()) return false;
  PlyProperty property;
  property.is_list = words.size() == 5 && words[1] == "list";
  if (!property.is_list && words.size() != 3) return false;
  if (property.is_list) {
    const auto count_type = TypeNamed(words[2]);
    if (!count_type || *count_type == PlyType::kFloat ||
        *count_type == PlyType::kDouble) {
      return false;
    }
    property.count_type = *count_type;
  }
  const auto type = TypeNamed(words[words.size() - 2]);
  if (!type) return false;
  property.type = *type;
  property.name = words.back();
  header.elements.back().properties.push_back(std::move(property));
  return true;
}

}  // namespace

std::size_t SizeOf(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat:
      return 4;
    case PlyType::kDouble:
      return 8;
  }
  return 0;
}

bool HoldsFaces(const PlyElement& element) {
  return element.name == "face" || element.name == "tristrips" ||
         element.name == "range_grid";
}

bool HoldsLists(const PlyElement& element) {
  return std::ranges::any_of(element.properties, [](const PlyProperty& property) {
    return property.is_list && property.type != PlyType::kFloat &&
           property.type != PlyType::kDouble;
  });
}

Result<PlyHeader> ParsePlyHeader(std::string_view bytes) {
  PlyHeader header;
  bool has_format = false;
  for (std::size_t begin = 0, line_number = 1; begin < bytes.size(); ++line_number) {
    const std::size_t end = bytes.find('\n', begin);
    if (end == std::string_view::npos) break;
    const std::string_view line = bytes.substr(begin, end - begin);
    begin = end + 1;
    const auto words = TokensOf(line);
    const std::string_view keyword = words.empty() ? "" : words[0];
    if (keyword == "end_header" && has_format) {
      header.size = begin;
      return header;
    }
    bool understood = true;
    if (line_number == 1) {
      understood = words.size() == 1 && keyword == "ply";
    } else if (keyword == "format") {
      understood = has_format = ParseFormat(words, header);
    } else if (keyword == "comment") {
      header.comments.push_back(CommentOf(line));
    } else if (keyword == "element") {
      understood = ParseElement(words, header);
    } else if (keyword == "property") {
      understood = ParseProperty(words, header);
    } else {
      understood = keyword == "obj_info";
    }
    if (!understood) {
      return Fail(
          ErrorCode::kUnreadable,
          fmt::format(
              "line {} is not a line of a PLY header; check that this is a PLY file",
              line_number));
    }
  }
  return Fail(
      ErrorCode::kUnreadable,
      "no PLY header that ends with end_header; check that this is a whole PLY file");
}

}  // namespace intaglio::io
