#include "services/cli/flags/drive_profile_flag.h"

#include "engrave/core/try.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio {

Result<DriveProfile> NamedDriveProfile(const std::string& name_or_file) {
  return ReadDriveProfile(INTAGLIO_TRY(
      command_line::FindSupplied(name_or_file, command_line::kSuppliedDrives)));
}

}  // namespace intaglio
