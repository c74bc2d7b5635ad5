#pragma once

#include <string>

#include "engrave/core/result.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio {

/// The drive profile that a command names: a file, or a supplied one. kNotFound: lists
/// the supplied ones; and the errors of ReadDriveProfile.
Result<DriveProfile> NamedDriveProfile(const std::string& name_or_file);

}  // namespace intaglio
