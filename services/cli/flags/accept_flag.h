#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/cli/flags/job_flags.h"
#include "services/client/job_client.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --accept: what the person who types it accepts: a warning, or the answer to a question
/// of a preview, "up=y", "unit=25.4".
struct AcceptFlag {
  std::vector<std::string> given;

  bool breakage() const;
};

/// Why a job is not engraved, with the remedy: a warning of it is not accepted. nullopt:
/// none needs to be, or it is.
std::optional<Error> WhyRefused(const client::JobView& job, const AcceptFlag& flag);

/// Sets the options --up and --unit as they were answered. kInvalidValue: another value
/// was given, by an answer or by the option itself.
Status TakeAnswers(const AcceptFlag& flag, JobFlags& job);

/// Adds warnings alone: for a command without models.
void AddAcceptFlag(command_line::Command command, AcceptFlag& flag);
/// Adds warnings and answers.
void AddAcceptAndAnswers(command_line::Command command, AcceptFlag& flag);
/// Adds answers alone: for a command that engraves nothing.
void AddAnswers(command_line::Command command, AcceptFlag& flag);

}  // namespace intaglio::cli
