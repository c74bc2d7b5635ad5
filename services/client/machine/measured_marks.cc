#include "services/client/machine/measured_marks.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/calibrate/mark_centres.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/image/image_file.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/number_text.h"
#include "engrave/io/whole_file.h"
#include "services/job/convert/model_kind.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
constexpr double kMaxMarks = 1e6;

Result<MeasuredMarks> ReadTable(const fs::path& file) {
  const io::CsvTable table = INTAGLIO_TRY(io::ReadCsv(file));
  MeasuredMarks marks;
  if (table.rows.empty()) return marks;
  for (const char* column : {"x_mm", "y_mm"}) {
    if (table.Find(table.rows.front(), column) != nullptr) continue;
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: has no column {}; its first line has to name x_mm and "
                            "y_mm, and mark where the marks' numbers are known",
                            file.string(), column));
  }
  const bool numbered = table.Find(table.rows.front(), "mark") != nullptr;
  for (const io::CsvRow& row : table.rows) {
    const double x = INTAGLIO_TRY(NumberIn(table, row, "x_mm", file));
    const double y = INTAGLIO_TRY(NumberIn(table, row, "y_mm", file));
    marks.places_mm.emplace_back(x, y);
    if (!numbered) continue;
    const double number = INTAGLIO_TRY(NumberIn(table, row, "mark", file));
    if (!(number >= 1 && number <= kMaxMarks) || number != std::floor(number)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: line {}, mark: {} is no number of a mark, 1 and more",
                              file.string(), row.line_number, number));
    }
    marks.numbers.push_back(static_cast<int>(number) - 1);
  }
  return marks;
}

Result<MeasuredMarks> ReadPicture(const MarksFile& asked) {
  const std::string bytes =
      INTAGLIO_TRY(io::ReadWholeFile(asked.file, image::ImageLimits{}.max_file_bytes));
  const auto picture = image::ParseImage(bytes);
  if (!picture) {
    Error error = picture.error();
    error.message = asked.file.string() + ": " + error.message;
    return tl::unexpected(error);
  }
  const auto centres_px =
      calibrate::FindMarkCentres(*picture, {asked.mark_um / asked.pixel_um});
  if (!centres_px) {
    Error error = centres_px.error();
    error.message = asked.file.string() + ": " + error.message;
    return tl::unexpected(error);
  }
  MeasuredMarks marks;
  for (const Vec2& px : *centres_px) {
    marks.places_mm.push_back(asked.pixel_um / 1000 * Vec2(px.x(), -px.y()));
  }
  return marks;
}

}  // namespace

Result<double> NumberIn(const io::CsvTable& table, const io::CsvRow& row,
                        const char* column, const fs::path& file) {
  std::string text = *table.Find(row, column);
  if (const auto comma = text.find(','); comma != std::string::npos) text[comma] = '.';
  if (const auto number = io::ParseFinite(text)) return *number;
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{}: line {}, {}: '{}' is not a number; correct it, or remove "
                          "the line",
                          file.string(), row.line_number, column, text),
              text);
}

Result<MeasuredMarks> ReadMarks(const MarksFile& asked) {
  const std::string extension = io::LowerCaseExtension(asked.file.extension().string());
  if (extension == "csv") return ReadTable(asked.file);
  if (KindOfFile(asked.file.string()) == ModelKind::kImage) return ReadPicture(asked);
  const auto table = INTAGLIO_TRY(formats::ReadPoints(asked.file));
  MeasuredMarks marks;
  for (const Vec3& p : table.points_mm) marks.places_mm.emplace_back(p.head<2>());
  return marks;
}

}  // namespace intaglio::client
