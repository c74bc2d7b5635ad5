#include "engrave/formats/point_table_rules.h"

#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {

void RequireWritable(const PointTable& table) {
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    const Vec3& p = table.points_mm[i];
    Require(p.allFinite(), "point {} to write is not finite: ({}, {}, {})", i, p.x(),
            p.y(), p.z());
  }
  for (const NamedColumn& column : table.columns) {
    const bool taken = column.name == "x" || column.name == "y" || column.name == "z";
    Require(!column.name.empty() && !taken &&
                column.name.find_first_of(" \t\r\n") == std::string::npos,
            "'{}' cannot name a column", column.name);
    const std::size_t count =
        std::visit([](const auto& values) { return values.size(); }, column.values);
    Require(count == table.points_mm.size(), "column {} has {} values for {} points",
            column.name, count, table.points_mm.size());
  }
  for (const std::string& comment : table.comments) {
    Require(comment.find_first_of("\r\n") == std::string::npos,
            "a comment must be one line: '{}'", comment);
  }
}

std::string OneLine(std::string_view comment) {
  std::string line(comment);
  std::replace(line.begin(), line.end(), '\r', ' ');
  return line;
}

Result<PointTable> ReadAndParse(const std::filesystem::path& file,
                                const PointFileLimits& limits,
                                Result<PointTable> (*parse)(std::string_view,
                                                            const PointFileLimits&)) {
  const std::string bytes = INTAGLIO_TRY(io::ReadWholeFile(file, limits.max_file_bytes));
  return parse(bytes, limits).map_error([&](const Error& error) {
    return io::AboutFile(error, file);
  });
}

}  // namespace intaglio::formats
