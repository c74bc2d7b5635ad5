#pragma once

// What a job will look like and take, before it is engraved: the points as the
// discretizers make them, warnings, the size in the block, and the time that an order and
// a plan of them give. No machine and no service takes part. `intaglio preview` writes
// the result into a folder; a console can show the page as it is.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/preview.pb.h"
#include "proto/task.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio::client {

struct PreviewOptions {
  ReadLimits limits;
  Executor executor;
  /// More points than this are not all ordered and planned: the time of the others
  /// follows from a sample of this size. 48 000 take below a second on two cores.
  std::size_t max_planned_points = 48'000;
  std::string made_utc;  ///< for the record
  Warnings found = {};   ///< before the preview, of the same job
};

/// Stages of the work by name, "read", "points", ..., and how far each one is; false
/// cancels.
using PreviewProgress =
    std::function<bool(const char* stage, std::uint64_t done, std::uint64_t total)>;

struct PreviewPicture {
  std::string file;  ///< "preview.png"; of a channel "preview-channel-2.png"
  std::vector<std::uint8_t> png;
};

struct Preview {
  JobPreview figures;
  /// The first one is of all points; one of each channel's block follows, of a job with
  /// several.
  std::vector<PreviewPicture> pictures;
  /// For the view of the page that turns (preview_view.h); glass frame.
  PointList points_mm;
};

/// `job` is frozen (services/job/files/freeze.h): its result folder is not used. Errors:
/// those of the models, with the file's name; points outside the block or out of the
/// machine's travel; no points; kCancelled.
Result<Preview> MakePreview(const FrozenJob& job, const PreviewOptions& options,
                            const PreviewProgress& progress);

/// Size and place of the points in the block of the job.
void SetPlace(const JobSpec& job, const PointList& points_mm, JobPreview& figures);

inline constexpr const char* kPreviewFile = "preview.png";
inline constexpr const char* kPreviewPage = "preview.html";
inline constexpr const char* kPreviewFigures = "preview.json";

/// The verdict that its warnings give, a value of preview_text.h.
const char* VerdictOf(const Warnings& warnings);

/// The figures alone; makes the folder. kIo.
Status WriteFigures(const std::filesystem::path& folder, const JobPreview& figures);
/// Page, figures and pictures, each whole or not at all; makes the folder. kIo.
Status WritePreview(const std::filesystem::path& folder, const Preview& preview);

}  // namespace intaglio::client
