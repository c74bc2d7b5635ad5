#include "services/client/machine/measured_cube.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "engrave/core/try.h"
#include "engrave/io/csv.h"
#include "services/client/machine/measured_marks.h"

namespace intaglio::client {
namespace {

constexpr std::array<const char*, 3> kWanted = {"x_mm", "y_mm", "z_mm"};
constexpr std::array<const char*, 3> kMeasured = {"measured_x_mm", "measured_y_mm",
                                                  "measured_z_mm"};
constexpr double kMaxMarkNumber = 1e5;

Status CheckColumns(const io::CsvTable& table, const std::filesystem::path& file) {
  if (table.rows.empty()) return {};
  for (const char* column : {"mark", kWanted[0], kWanted[1], kWanted[2], kMeasured[0],
                             kMeasured[1], kMeasured[2]}) {
    if (table.Find(table.rows.front(), column) != nullptr) continue;
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: has no column {}; fill in the table cube.csv of the "
                            "cube's job",
                            file.string(), column));
  }
  return {};
}

}  // namespace

Result<std::vector<MeasuredCubeMark>> ReadMeasuredCube(
    const std::filesystem::path& file) {
  const io::CsvTable table = INTAGLIO_TRY(io::ReadCsv(file));
  INTAGLIO_TRY(CheckColumns(table, file));
  std::vector<MeasuredCubeMark> marks;
  for (const io::CsvRow& row : table.rows) {
    MeasuredCubeMark mark;
    mark.line_number = row.line_number;
    const double number = INTAGLIO_TRY(NumberIn(table, row, "mark", file));
    if (!(number >= 1 && number <= kMaxMarkNumber) || number != std::floor(number)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: line {}, mark: {} is no number of a mark, 1 and more",
                              file.string(), row.line_number, number));
    }
    mark.number = static_cast<int>(number);
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      mark.wanted_mm[axis] = INTAGLIO_TRY(NumberIn(table, row, kWanted[i], file));
      mark.measured_mm[axis] = std::numeric_limits<double>::quiet_NaN();
      if (table.Find(row, kMeasured[i])->find_first_not_of(" \t") == std::string::npos)
        continue;
      mark.measured_mm[axis] = INTAGLIO_TRY(NumberIn(table, row, kMeasured[i], file));
      any = true;
    }
    if (any) marks.push_back(mark);
  }
  return marks;
}

}  // namespace intaglio::client
