#include "engrave/mesh/files/ply_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "engrave/io/ply_header.h"

// Assimp (5.2) trusts a header: one that does not end is read for ever; room is made for
// as many rows as a list is declared to have, 20 GB for a file of 200 bytes; and the rows
// of a second list of vertices, or of faces, are written behind the room of the first. It
// accepts more as a declaration than the format defines:
//  - a line ends at a carriage return, line feed, form feed or zero byte;
//  - the rows of a list whose name it does not know are counted by a number that is in
//    the name's place: "element 2000000000 0".

namespace intaglio::mesh {
namespace {

using namespace std::string_view_literals;

/// The number of the digits that it begins with; 0: there are none.
std::uint64_t NumberAt(std::string_view word) {
  std::uint64_t number = 0;
  const auto parsed = std::from_chars(word.data(), word.data() + word.size(), number);
  return parsed.ec == std::errc::result_out_of_range
             ? std::numeric_limits<std::uint64_t>::max()
             : number;
}

/// Whether the library finds a line end where there is none, or no last line.
bool IsSeenOtherwise(std::string_view header) {
  if (!header.ends_with("\nend_header\n") && !header.ends_with("\nend_header\r\n")) {
    return true;
  }
  if (header.find_first_of("\f\0"sv) != std::string_view::npos) return true;
  for (std::size_t at = header.find('\r'); at != std::string_view::npos;
       at = header.find('\r', at + 1)) {
    if (header[at + 1] != '\n') return true;
  }
  return false;
}

}  // namespace

Status CheckPlyHeader(const ImportSource& source, std::string_view beginning,
                      std::uint64_t byte_count) {
  beginning = beginning.substr(0, kMaxPlyHeaderSize);
  const Result<io::PlyHeader> header = io::ParsePlyHeader(beginning);
  if (!header) return source.Refuse(ErrorCode::kUnreadable, header.error().message);
  if (IsSeenOtherwise(beginning.substr(0, header->size))) {
    return source.RefuseAsUnreadable("its header has control characters inside a line");
  }
  int vertex_lists = 0, face_lists = 0;
  for (const io::PlyElement& element : header->elements) {
    // A row takes a byte at least.
    if (std::max(element.count, NumberAt(element.name)) > byte_count) {
      return source.RefuseAsUnreadable(
          fmt::format("it has {} bytes, too few for \"element {:.30} {}\"", byte_count,
                      element.name, element.count));
    }
    if (element.name == "vertex") ++vertex_lists;
    if (io::HoldsFaces(element)) ++face_lists;
  }
  if (vertex_lists <= 1 && face_lists <= 1) return {};
  return source.Refuse(ErrorCode::kUnreadable,
                       fmt::format("it cannot be read as ply (its header declares {} "
                                   "lists of vertices and {} of faces); export it again "
                                   "as one mesh",
                                   vertex_lists, face_lists));
}

}  // namespace intaglio::mesh
