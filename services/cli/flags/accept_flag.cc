#include "services/cli/flags/accept_flag.h"

#include <fmt/format.h>

#include "engrave/core/warning.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::cli {

std::optional<Error> WhyRefused(const client::JobView& job, const AcceptFlag& flag) {
  const Warning* consent = job.open_consent();
  if (consent == nullptr || flag.breakage()) return std::nullopt;
  return Error{ErrorCode::kRefused,
               fmt::format("not engraved: {}; to engrave it all the same, give {}",
                           consent->text, AcceptOption(*consent)),
               ""};
}

void AddAcceptFlag(command_line::Command command, AcceptFlag& flag) {
  command
      .AddOption("--accept", flag.code,
                 "accept a warning that keeps a job from being armed: breakage, the "
                 "glass may break; your name is kept with the job")
      .OneOf({WarningCodeName(WarningCode::kBreakage)});
}

}  // namespace intaglio::cli
