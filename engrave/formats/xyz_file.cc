#include <fmt/format.h>

#include "engrave/formats/atomic_file.h"
#include "engrave/formats/coordinate_lines.h"
#include "engrave/formats/number_text.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/formats/whole_file.h"

namespace intaglio::formats {

Status WriteXyz(const std::filesystem::path& file, const PointTable& table) {
  RequireWritable(table);
  Result<AtomicFile> out = AtomicFile::Create(file);
  if (!out) return tl::unexpected(out.error());
  std::string line;
  for (const std::string& comment : table.comments) {
    line = fmt::format("# {}\n", comment);
    if (Status status = out->Write(line); !status) return status;
  }
  for (const Vec3& p : table.points_mm) {
    line.clear();
    for (int axis = 0; axis < 3; ++axis) {
      AppendShortest(p[axis], line);
      line += axis < 2 ? ' ' : '\n';
    }
    if (Status status = out->Write(line); !status) return status;
  }
  return out->Commit();
}

Result<PointTable> ParseXyz(std::string_view bytes, const PointFileLimits& limits) {
  return ParseCoordinateLines(bytes, limits);
}

Result<PointTable> ReadXyz(const std::filesystem::path& file,
                           const PointFileLimits& limits) {
  return ReadAndParse(file, limits, ParseXyz);
}

}  // namespace intaglio::formats
