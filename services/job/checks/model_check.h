#pragma once

// Whether the fields of a model fit together; its files are not read.

#include <string>

#include "proto/job.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// `path`: of the model, "models[0]".
void CheckModel(const Model& model, const std::string& path, Findings& findings);

/// The spacings that clouds of points have of their own. `job` with its defaults filled
/// in.
void CheckOwnSpacing(const JobSpec& job, Findings& findings);

/// The modules of codes have room for three rows of points; those of a code that is
/// scaled are not known before it is placed. `job` with its defaults filled in.
void CheckModules(const JobSpec& job, Findings& findings);

}  // namespace intaglio
