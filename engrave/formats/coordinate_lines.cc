#include "engrave/formats/coordinate_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engrave/core/try.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"

namespace intaglio::formats {
namespace {

constexpr std::string_view kSeparators = " \t,;";

/// Takes the next number off the line, and what separates it from the one before.
bool TakeNumber(std::string_view& line, double& value, std::string_view& separator) {
  separator = line.substr(0, line.find_first_not_of(kSeparators));
  line.remove_prefix(separator.size());
  const std::string_view word = line.substr(0, line.find_first_of(kSeparators));
  line.remove_prefix(word.size());
  const std::optional<double> number = io::ParseNumber(word);
  value = number.value_or(0);
  return number.has_value();
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// The line with its decimal commas as points; empty: it has none. They are, where three
/// or more words between blanks, tabs or semicolons hold one comma each at most, and
/// commas stand between digits and beside no decimal point: "21,3 20 27,9".
std::string WithDecimalPoints(std::string_view line) {
  std::string changed(line);
  std::size_t words = 0, commas = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool begins =
        i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t' || line[i - 1] == ';';
    if (line[i] == '.') return {};
    if (begins && line[i] != ' ' && line[i] != '\t' && line[i] != ';') {
      ++words;
      if (std::ranges::count(line.substr(i, line.find_first_of(" \t;", i) - i), ',') > 1)
        return {};
    }
    if (line[i] != ',') continue;
    if (i == 0 || i + 1 == line.size() || !IsDigit(line[i - 1]) || !IsDigit(line[i + 1]))
      return {};
    changed[i] = '.';
    ++commas;
  }
  return words >= 3 && commas > 0 ? changed : std::string();
}

std::string CommentOf(std::string_view line) {
  line.remove_prefix(line.find('#') + 1);
  if (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  return OneLine(line);
}

/// "1,5,2,5,3,5": three numbers with decimal commas, or six.
bool MayHaveDecimalCommas(std::string_view line) {
  return std::count(line.begin(), line.end(), ',') == 5 &&
         line.find_first_not_of("0123456789+-,") == std::string_view::npos;
}

/// Numbers of a file whose every line may have decimal commas have nothing that says
/// whether they are; one other line says that commas divide.
struct DoubtfulLines {
  std::size_t count = 0, first = 0;

  void See(std::string_view line, std::size_t line_number) {
    if (MayHaveDecimalCommas(line) && ++count == 1) first = line_number;
  }
};

Status ReadLine(std::string_view line, std::size_t line_number, PointTable& table) {
  const std::size_t first = line.find_first_not_of(kSeparators);
  if (first == std::string_view::npos) return {};
  if (line[first] == '#') {
    table.comments.push_back(CommentOf(line));
    return {};
  }
  Vec3 p;
  const std::string with_points = WithDecimalPoints(line);
  std::string_view rest = with_points.empty() ? line : with_points;
  std::array<std::string_view, 3> separators;
  for (int axis = 0; axis < 3; ++axis) {
    if (TakeNumber(rest, p[axis], separators.at(axis))) continue;
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("line {} is not three numbers: \"{:.60}\"; write x y z in mm, "
                    "with a decimal point",
                    line_number, line));
  }
  // Of "1,234.5 2 3" nobody knows which of its commas and blanks divide numbers.
  const bool are_mixed = (separators[1].find(',') == std::string_view::npos) !=
                         (separators[2].find(',') == std::string_view::npos);
  if (are_mixed && rest.find_first_not_of(kSeparators) != std::string_view::npos) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("line {} has commas and other separators between more than "
                            "three numbers: \"{:.60}\"; write x y z in mm, with a "
                            "decimal point and blanks",
                            line_number, line));
  }
  if (!p.allFinite()) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("line {} has a point at ({}, {}, {}), which is not finite; remove it",
                    line_number, p.x(), p.y(), p.z()));
  }
  table.points_mm.push_back(p);
  return {};
}

}  // namespace

tl::unexpected<Error> MorePointsThanAllowed(const PointFileLimits& limits) {
  return Fail(ErrorCode::kTooLarge,
              fmt::format("it has more than the {} points allowed; thin it out or raise "
                          "the limit",
                          limits.max_points));
}

Result<PointTable> ParseCoordinateLines(std::string_view bytes,
                                        const PointFileLimits& limits) {
  bytes = io::WithoutByteOrderMark(bytes);
  PointTable table;
  DoubtfulLines doubtful;
  std::size_t line_number = 1;
  for (std::size_t begin = 0; begin < bytes.size(); ++line_number) {
    const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
    std::string_view line = bytes.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    begin = end + 1;
    INTAGLIO_TRY(ReadLine(line, line_number, table));
    doubtful.See(line, line_number);
    if (table.points_mm.size() > limits.max_points) return MorePointsThanAllowed(limits);
  }
  if (table.points_mm.empty()) {
    return Fail(ErrorCode::kMissing, "it has no points; write x y z a line, in mm");
  }
  if (doubtful.count == table.points_mm.size()) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("line {} and all others have six numbers divided by commas, or "
                    "three with decimal commas; write x y z in mm, with a decimal "
                    "point and blanks",
                    doubtful.first));
  }
  return table;
}

}  // namespace intaglio::formats
