#include "engrave/mesh/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

// Assimp (5.2) is easily taken in: a header that does not end is read for ever; room is
// made for as many rows as a list is said to have, 20 GB for a file of 200 bytes; and the
// rows of a second list of vertices, or of faces, are written behind the room of the
// first. What it takes for a declaration is more than the format knows:
//  - a line ends at a carriage return, line feed, form feed or zero byte;
//  - the rows of a list whose name it does not know are counted by a number that stands
//    in the name's place: "element 2000000000".

namespace intaglio::mesh {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kLineEnds = "\r\n\f\0"sv, kBlanks = " \t"sv;

bool HoldsFaces(std::string_view name) {
  return name == "face" || name == "tristrips" || name == "range_grid";
}

std::string_view TakeWord(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

/// Of the digits that it begins with; 0: there are none.
std::uint64_t NumberAt(std::string_view word) {
  std::uint64_t number = 0;
  const auto parsed = std::from_chars(word.data(), word.data() + word.size(), number);
  return parsed.ec == std::errc::result_out_of_range
             ? std::numeric_limits<std::uint64_t>::max()
             : number;
}

std::optional<PlyList> ListOf(std::string_view line) {
  std::string_view rest = line;
  if (TakeWord(rest) != "element") return std::nullopt;
  const std::string_view name = TakeWord(rest);
  return PlyList{line, name, std::max(NumberAt(name), NumberAt(TakeWord(rest)))};
}

}  // namespace

std::vector<PlyList> PlyListsOf(std::string_view header) {
  std::vector<PlyList> lists;
  for (std::size_t begin = 0; begin < header.size();) {
    const std::size_t end =
        std::min(header.find_first_of(kLineEnds, begin), header.size());
    if (const auto list = ListOf(header.substr(begin, end - begin))) {
      lists.push_back(*list);
    }
    begin = end + 1;
  }
  return lists;
}

Status CheckPlyHeader(const ImportSource& source, std::string_view beginning,
                      std::uint64_t byte_count) {
  constexpr std::string_view kEnd = "\nend_header";
  beginning = beginning.substr(0, kMaxPlyHeaderSize);
  const std::size_t end = beginning.find(kEnd);
  const std::size_t behind = end + kEnd.size();
  if (end == std::string_view::npos || behind >= beginning.size() ||
      (beginning[behind] != '\n' && beginning[behind] != '\r')) {
    return source.Refuse(ErrorCode::kUnreadable,
                         "it cannot be read as ply (its header does not end with a line "
                         "end_header); check that it is complete, or export it again");
  }
  int vertex_lists = 0, face_lists = 0;
  for (const PlyList& list : PlyListsOf(beginning.substr(0, end))) {
    // A row takes a byte at least.
    if (list.row_count > byte_count) {
      return source.RefuseAsUnreadable(
          fmt::format("it has {} bytes, too few for \"{:.47}\"", byte_count, list.line));
    }
    if (list.name == "vertex") ++vertex_lists;
    if (HoldsFaces(list.name)) ++face_lists;
  }
  if (vertex_lists <= 1 && face_lists <= 1) return {};
  return source.Refuse(ErrorCode::kUnreadable,
                       fmt::format("it cannot be read as ply (its header declares {} "
                                   "lists of vertices and {} of faces); export it again "
                                   "as one mesh",
                                   vertex_lists, face_lists));
}

}  // namespace intaglio::mesh
