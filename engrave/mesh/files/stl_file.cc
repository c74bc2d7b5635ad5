#include "engrave/mesh/files/stl_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/number_text.h"
#include "engrave/mesh/files/triangle_welder.h"

namespace intaglio::mesh {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary values are taken as they lie in memory");

using Corner = CornerWelder::Corner;

constexpr std::size_t kHeaderSize = 84;
constexpr std::size_t kTriangleSize = 50;
constexpr std::size_t kNormalSize = 12;

// ---- binary -----------------------------------------------------------------

std::uint32_t CountOf(std::string_view header) {
  std::uint32_t count = 0;
  std::memcpy(&count, header.data() + kHeaderSize - sizeof count, sizeof count);
  return count;
}

Result<TriangleMesh> ReadBinary(ByteReader& bytes, std::uint64_t count,
                                const ImportSource& source) {
  if (count > source.options.max_triangles) return source.RefuseTriangleCount();
  TriangleWelder welder(source, count);
  constexpr std::size_t kTrianglesARead = 20'000;
  std::vector<char> buffer(kTrianglesARead * kTriangleSize);
  while (count > 0) {
    const auto wanted =
        std::min<std::uint64_t>(count, kTrianglesARead) * std::uint64_t{kTriangleSize};
    if (bytes.Read(std::span(buffer).first(wanted)) != wanted) {
      return source.Refuse(ErrorCode::kIo,
                           "it cannot be read to its end; check the disk, and that no "
                           "program writes the file");
    }
    for (std::size_t at = 0; at < wanted; at += kTriangleSize) {
      std::array<Corner, 3> corners;
      std::memcpy(&corners, buffer.data() + at + kNormalSize, sizeof corners);
      INTAGLIO_TRY(welder.Add(corners));
    }
    count -= wanted / kTriangleSize;
  }
  return welder.Take();
}

// ---- text -------------------------------------------------------------------

bool IsBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

bool IsToken(std::string_view text, std::string_view lower_case) {
  return std::equal(text.begin(), text.end(), lower_case.begin(), lower_case.end(),
                    [](char c, char expected) { return io::LowerCase(c) == expected; });
}

/// The tokens of a line one after another.
class Tokens {
 public:
  explicit Tokens(std::string_view rest) : rest_(rest) {}
  std::string_view Next() {
    std::size_t begin = 0;
    while (begin < rest_.size() && IsBlank(rest_[begin])) ++begin;
    std::size_t end = begin;
    while (end < rest_.size() && !IsBlank(rest_[end])) ++end;
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }

 private:
  std::string_view rest_;
};

class TextReader {
 public:
  TextReader(const ImportSource& source, std::size_t expected_triangle_count)
      : source_(source), welder_(source, expected_triangle_count) {}

  Status TakeLine(std::string_view line);
  Result<TriangleMesh> Take();

 private:
  tl::unexpected<Error> Refuse(std::string_view what) const {
    return source_.RefuseAsUnreadable(fmt::format("line {} {}", line_number_, what));
  }
  Status TakeCorner(Tokens& words, std::string_view line);
  Status EndFacet();

  const ImportSource& source_;
  TriangleWelder welder_;
  std::size_t line_number_ = 0;
  bool in_solid_ = false;
  bool in_facet_ = false;
  std::array<Corner, 3> corners_{};
  std::size_t corner_count_ = 0;
};

Status TextReader::TakeCorner(Tokens& words, std::string_view line) {
  if (!in_facet_ || corner_count_ == corners_.size()) {
    return Refuse("has an extra vertex, or one outside a facet");
  }
  Corner& corner = corners_[corner_count_++];
  for (float& coordinate : corner) {
    const std::optional<float> number = io::ParseNumber<float>(words.Next());
    if (!number) return Refuse(fmt::format("is not a vertex: \"{:.60}\"", line));
    coordinate = *number;
  }
  return {};
}

Status TextReader::EndFacet() {
  if (!in_facet_ || corner_count_ != corners_.size()) {
    return Refuse(
        fmt::format("ends a facet of {}", Counted(corner_count_, "vertex", "vertices")));
  }
  in_facet_ = false;
  return welder_.Add(corners_);
}

Status TextReader::TakeLine(std::string_view line) {
  ++line_number_;
  Tokens words(line);
  // Some writers put several of these on one line.
  for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
    if (IsToken(word, "vertex")) {
      if (Status status = TakeCorner(words, line); !status) return status;
    } else if (IsToken(word, "facet")) {
      if (!in_solid_ || in_facet_) return Refuse("begins a facet in the wrong place");
      in_facet_ = true;
      corner_count_ = 0;
      for (int i = 0; i < 4; ++i) words.Next();  // normal x y z, which may be no numbers
    } else if (IsToken(word, "endfacet")) {
      if (Status status = EndFacet(); !status) return status;
    } else if (IsToken(word, "solid") || IsToken(word, "endsolid")) {
      const bool begins = IsToken(word, "solid");
      if (in_facet_ || in_solid_ == begins) return Refuse("has a solid in a wrong place");
      in_solid_ = begins;
      return {};  // the rest is its name
    } else if (!IsToken(word, "outer") && !IsToken(word, "loop") &&
               !IsToken(word, "endloop")) {
      return Refuse(fmt::format("is not a line of an STL: \"{:.60}\"", line));
    }
  }
  return {};
}

Result<TriangleMesh> TextReader::Take() {
  if (in_solid_) {
    return source_.RefuseAsUnreadable(fmt::format(
        "it ends after line {} without endsolid, so it is truncated", line_number_));
  }
  return welder_.Take();
}

/// Feeds the lines of `beginning` and of all that follows it.
Result<TriangleMesh> ReadText(std::string beginning, ByteReader& bytes,
                              std::uint64_t byte_count, const ImportSource& source) {
  constexpr std::size_t kTextSize = 1 << 20;  // and the longest line
  constexpr std::size_t kBytesATriangle = 230;
  TextReader reader(source,
                    std::min(byte_count / kBytesATriangle, source.options.max_triangles));
  std::string text = std::move(beginning);
  char line_end = '\0';
  for (bool at_end = false; !at_end;) {
    const std::size_t begin = text.size();
    text.resize(kTextSize);
    text.resize(begin + bytes.Read(std::span(text).subspan(begin)));
    at_end = text.size() < kTextSize;
    // Lines of old computers end with a carriage return alone.
    if (line_end == '\0') line_end = text.find('\n') == text.npos ? '\r' : '\n';
    std::string_view rest = text;
    for (std::size_t size = rest.find(line_end);
         size != std::string_view::npos || (at_end && !rest.empty());
         size = rest.find(line_end)) {
      const std::string_view line = rest.substr(0, size);
      INTAGLIO_TRY(reader.TakeLine(line));
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    }
    if (rest.size() == kTextSize) {
      return source.RefuseAsUnreadable("a line is longer than a megabyte");
    }
    text.erase(0, text.size() - rest.size());
  }
  return reader.Take();
}

/// Whether the file's first bytes are of a text: "solid" at the beginning, and no zeros,
/// which binary files that begin so have in the same place.
bool IsText(std::string_view beginning) {
  if (beginning.find('\0') != std::string_view::npos) return false;
  const std::size_t first = beginning.find_first_not_of(" \t\r\n\v\f");
  return first != std::string_view::npos && IsToken(beginning.substr(first, 5), "solid");
}

}  // namespace

Result<TriangleMesh> ReadStl(ByteReader& bytes, std::uint64_t byte_count,
                             const ImportSource& source) {
  std::string header(kHeaderSize, '\0');
  header.resize(bytes.Read(header));
  const bool whole = header.size() == kHeaderSize;
  const std::uint64_t count = whole ? CountOf(header) : 0;
  const std::uint64_t rest_size = byte_count - std::min(byte_count, kHeaderSize + 0ul);
  const bool size_agrees = whole && rest_size == count * kTriangleSize;
  if (!size_agrees) {
    header = std::string(io::WithoutByteOrderMark(header));
    if (IsText(header)) return ReadText(std::move(header), bytes, byte_count, source);
  }
  if (!whole) {
    return source.RefuseAsUnreadable("it neither begins with \"solid\" nor has a header");
  }
  // A few bytes behind the last triangle are the padding of some writers.
  if (rest_size / kTriangleSize != count) {
    return source.RefuseAsUnreadable(
        fmt::format("its header declares {}, its size allows {}",
                    Counted(count, "triangle"), rest_size / kTriangleSize));
  }
  return ReadBinary(bytes, count, source);
}

}  // namespace intaglio::mesh
