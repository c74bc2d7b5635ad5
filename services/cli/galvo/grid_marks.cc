#include "services/cli/galvo/grid_marks.h"

#include <fmt/format.h>

#include <iostream>
#include <string>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/grid_match.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "engrave/io/whole_file.h"

namespace intaglio::cli {
namespace {

constexpr int kQuarterDeg = 90;

Result<double> CoordinateIn(const io::CsvTable& table, const io::CsvRow& row,
                            std::string_view column, const std::string& file) {
  const std::string* text = table.Find(row, column);
  if (text == nullptr) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: has no column {}; give command_x_mm, command_y_mm, "
                            "measured_x_mm and measured_y_mm",
                            file, column));
  }
  const auto number = io::ParseFinite(*text);
  if (number) return *number;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{}:{}: {} {:?} is no number; leave the line out when the mark "
                          "was not found",
                          file, row.line_number, column, *text),
              *text);
}

Result<std::vector<galvo::GridMark>> ReadCommandedMarks(const std::string& file) {
  const auto table = INTAGLIO_TRY(io::ReadCsv(file));
  std::vector<galvo::GridMark> marks;
  for (const io::CsvRow& row : table.rows) {
    galvo::GridMark mark;
    mark.command_mm.x() = INTAGLIO_TRY(CoordinateIn(table, row, "command_x_mm", file));
    mark.command_mm.y() = INTAGLIO_TRY(CoordinateIn(table, row, "command_y_mm", file));
    mark.measured_mm.x() = INTAGLIO_TRY(CoordinateIn(table, row, "measured_x_mm", file));
    mark.measured_mm.y() = INTAGLIO_TRY(CoordinateIn(table, row, "measured_y_mm", file));
    marks.push_back(mark);
  }
  return marks;
}

/// What the match shows, a line each.
void PrintMatch(const galvo::GridMatch& match, int nodes) {
  std::cout << fmt::format("grid          {} of {} nodes found, {}\n", match.marks.size(),
                           nodes * nodes, Counted(match.left_out_count, "other spot"));
  if (!match.quarter_turns) {
    std::cout << "direction     not marked: taken as upright, x to the right\n";
  } else if (*match.quarter_turns == 0) {
    std::cout << "direction     upright\n";
  } else {
    std::cout << fmt::format("direction     turned by {} degrees, and turned back\n",
                             kQuarterDeg * *match.quarter_turns);
  }
}

/// Marks whose commands are not known: each is matched to a node of the grid.
Result<std::vector<galvo::GridMark>> ReadPlaces(const GridMarksOptions& options) {
  const std::string file = options.measured.file.string();
  if (!options.pitch_mm)
    return Fail(ErrorCode::kMissing, "--nodes: needs --pitch, of the grid, mm");
  if (options.measured.file.extension() != ".csv" &&
      (options.measured.pixel_um <= 0 || options.measured.mark_um <= 0)) {
    return Fail(ErrorCode::kMissing,
                "--pixel and --mark-size: are missing; give the side of a pixel on the "
                "piece (a scan of 1200 dpi has 21.167) and the diameter of a mark, um");
  }
  const auto measured = INTAGLIO_TRY(client::ReadMarks(options.measured));
  auto match = galvo::MatchGrid(measured.places_mm, options.nodes, *options.pitch_mm);
  if (!match) return tl::unexpected(io::AboutFile(match.error(), file));
  PrintMatch(*match, options.nodes);
  return std::move(match->marks);
}

}  // namespace

Result<std::vector<galvo::GridMark>> ReadGridMarks(const GridMarksOptions& options) {
  if (options.nodes > 0) return ReadPlaces(options);
  return ReadCommandedMarks(options.measured.file.string());
}

}  // namespace intaglio::cli
