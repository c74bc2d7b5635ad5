#pragma once

// The pictures of a job's folder: views.png, views-channel-N.png of a job of several
// channels, and the customer's.

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/render/customer_picture.h"
#include "engrave/render/views.h"
#include "proto/report.pb.h"
#include "services/client/proof/evidence/proof_evidence.h"

namespace intaglio::client {

/// What is written beside the views.
render::ViewsCaption ViewsCaptionOf(const JobReport& report, const Box3& work_mm);

/// The sentence on what the report rests, why it is not good, and its warnings.
std::vector<render::Note> NotesOf(const JobReport& report, const std::string& evidence);
/// 2026-11-23T08:12:34Z -> 2026-11-23 08:12 UTC.
std::string MinuteText(const std::string& utc);

/// The cracks; where the glass is not known, the planned points that were made, which are
/// collected in `made_mm`.
const PointList& PicturePoints(const Evidence& evidence, PointList& made_mm);

/// views.png, and views-channel-N.png. kIo.
Status WriteViews(const std::filesystem::path& folder, const Evidence& evidence,
                  const JobReport& report);

/// kIo.
Status WriteCustomerPicture(const std::filesystem::path& file, const Evidence& evidence,
                            const render::CustomerPicture& picture);
/// Draws it for a folder with path.ply and job.json.
Status WriteCustomerPicture(const std::filesystem::path& file,
                            const std::filesystem::path& folder,
                            const render::CustomerPicture& picture);

}  // namespace intaglio::client
