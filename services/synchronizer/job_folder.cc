#include "services/synchronizer/job_folder.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "services/cell/begun_job.h"

namespace intaglio::synchronizer {

namespace fs = std::filesystem;

Status MakeJobFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot make the result directory {}: {}", folder.string(),
                            error.message()),
                folder.string());
  }
  return {};
}

Status WritePlan(const fs::path& folder, const FrozenJob& job, const PointCloud& path) {
  formats::PointTable table;
  table.points_mm = path.points_mm;
  table.comments = {"path of job " + job.job_uid() +
                    ", glass frame, mm, in the order of engraving"};
  table.columns.push_back({"source", path.source});
  INTAGLIO_TRY(formats::WritePly(folder / kPathFile, table));
  return cell::WriteBegunJob(folder, job);
}

Result<PointCloud> ReadPath(const fs::path& folder) {
  const fs::path file = folder / kPathFile;
  if (!fs::exists(file)) {
    return Fail(ErrorCode::kNotFound,
                file.string() +
                    " is not there, but the job was begun: see that the folder "
                    "of its results is mounted, and check the block",
                file.string());
  }
  auto table = INTAGLIO_TRY(formats::ReadPly(file));
  const auto* source = table.Find<std::uint32_t>("source");
  if (source == nullptr) {
    return Fail(ErrorCode::kUnreadable,
                file.string() + " has no column 'source': the job cannot be continued",
                file.string());
  }
  PointCloud path;
  path.source = *source;
  path.points_mm = std::move(table.points_mm);
  return path;
}

}  // namespace intaglio::synchronizer
