#pragma once

#include "services/client/job_client.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio mount`: what a person has put into a machine, said without closing its shop.
void AddMountCommand(command_line::Command app);
/// `intaglio teach mount`: the same of the machine that is found, with its own profile.
void AddTeachMount(command_line::Command teach);

/// What is known, with what was named now in its place.
MountedParts MergedParts(MountedParts known, const MountedParts& named);

/// "els-03     60 x 30 x 20 N-BK7, f70 (ann@desk, 2026-11-26T14:00:00.000Z)".
std::string MountText(const std::string& cell, const client::MountView& mount);

/// After an arm: "60 x 30 x 20 N-BK7, f70: armed", as far as somebody has reported it.
void PrintMounted(client::JobClient& client, const std::string& cell, std::ostream& out);

}  // namespace intaglio::cli
