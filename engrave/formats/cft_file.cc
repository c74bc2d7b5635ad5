#include "engrave/core/try.h"
#include "engrave/formats/coordinate_lines.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/number_text.h"

namespace intaglio::formats {

Status WriteCft(const std::filesystem::path& file, const PointTable& table) {
  RequireWritable(table);
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  std::string line;
  for (const Vec3& p : table.points_mm) {
    line.clear();
    for (int axis = 0; axis < 3; ++axis) {
      io::AppendShortestFixed(p[axis], line);
      line += axis < 2 ? " " : "\r\n";
    }
    if (Status status = out.Write(line); !status) return status;
  }
  return out.Commit();
}

Result<PointTable> ParseCft(std::string_view bytes, const PointFileLimits& limits) {
  return ParseCoordinateLines(bytes, limits);
}

}  // namespace intaglio::formats
