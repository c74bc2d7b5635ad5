#pragma once

#include <optional>
#include <string>

#include "services/client/job_client.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --accept: warnings that the person who types it accepts.
struct AcceptFlag {
  std::string code;  ///< of WarningCode; empty: none

  bool breakage() const { return !code.empty(); }
};

/// Why a job is not engraved, with the remedy: a warning of it is not accepted. nullopt:
/// none needs to be, or it is.
std::optional<Error> WhyRefused(const client::JobView& job, const AcceptFlag& flag);

void AddAcceptFlag(command_line::Command command, AcceptFlag& flag);

}  // namespace intaglio::cli
