#pragma once

// The picture of a job of marks: views.png of its folder.

#include <filesystem>

#include "engrave/core/result.h"
#include "engrave/render/web/mark_views.h"
#include "proto/report.pb.h"
#include "services/client/proof/marks/mark_evidence.h"

namespace intaglio::client {

/// What is drawn: all marks of a piece, the first fields of a web; and the marks with the
/// gravest faults or errors, wherever they lie.
render::MarkViews MarkViewsOf(const MarkEvidence& evidence, const JobReport& report);

/// views.png. kIo.
Status WriteViews(const std::filesystem::path& folder, const MarkEvidence& evidence,
                  const JobReport& report);

}  // namespace intaglio::client
