#pragma once

// The folder of deploy/linuxcnc/start, and whether the HAL that was started in it runs.

#include <filesystem>
#include <string_view>

#include "engrave/core/result.h"
#include "services/drivers/linuxcnc/hal_text.h"

namespace intaglio::drivers {

/// What the HAL of `folder` is. A computer has one HAL, which any program reaches
/// whatever folder it names: so the file `identity` counts only while a process of the
/// HAL of this folder holds the file `lock`. kNotFound when none does; kUnreadable for a
/// damaged file. `line`: the field of the profile that names the folder, for the remedy.
Result<HalIdentity> ReadHalIdentity(const std::filesystem::path& folder,
                                    std::string_view line);

}  // namespace intaglio::drivers
