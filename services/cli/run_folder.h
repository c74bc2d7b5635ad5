#pragma once

// The folder of an `intaglio run`.

#include <filesystem>
#include <ostream>
#include <string>

#include "engrave/core/result.h"
#include "proto/report.pb.h"
#include "services/cli/flags/customer_picture_flags.h"

namespace intaglio::cli {

/// Makes the folder `out`, and `session` in it for the processes; removes what an earlier
/// run left in them, and nothing else. kIo with the option to change.
Status PrepareRunFolder(const std::filesystem::path& out,
                        const std::filesystem::path& session);

/// A DDS tag that no other run has.
std::string PrivateTag();

/// Prints the report and where it is, and draws the customer's picture if it is asked
/// for. kIo.
Status PresentProof(std::ostream& human, const JobReport& report,
                    const std::filesystem::path& out, bool is_recorded,
                    const CustomerPictureFlags& picture);

}  // namespace intaglio::cli
