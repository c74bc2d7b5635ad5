#pragma once

// What the body of a request says, as a message, and as a command about a job.

#include <google/protobuf/util/json_util.h>

#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "services/client/job_client.h"

namespace intaglio::console {

/// The message in a body; nullopt: another one, a field of another name among it.
template <typename Message>
std::optional<Message> BodyOf(const std::string& body) {
  Message message;
  const bool read =
      body.empty() || google::protobuf::util::JsonStringToMessage(body, &message).ok();
  return read ? std::optional(message) : std::nullopt;
}

/// What a command of this name asks for; nullopt: there is no such one.
std::optional<intaglio_JobCommandKind> CommandNamed(std::string_view name);

/// A command with what its body says; `token` of those that let a machine fire.
struct PostedCommand {
  client::JobOrder order;
  std::string token;
};

/// kInvalidValue: the body is not that of this command.
Result<PostedCommand> ReadCommand(intaglio_JobCommandKind kind, const std::string& body);

}  // namespace intaglio::console
