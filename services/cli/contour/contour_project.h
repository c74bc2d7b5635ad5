#pragma once

#include "engrave/contour/files/project_file.h"
#include "services/cli/contour/contour_files.h"

namespace intaglio::cli {

/// Elements and holes as a project, each element in a separate group and nodes shared, as
/// the source keeps them. kUnsupported, with the element's description: an outline, or a
/// track along an arc, which a project does not have.
Result<contour::Project> ProjectOf(const CourseFiles& files);

}  // namespace intaglio::cli
