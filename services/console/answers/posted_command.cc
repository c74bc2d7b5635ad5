#include "services/console/answers/posted_command.h"

#include "proto/console.pb.h"

namespace intaglio::console {

std::optional<intaglio_JobCommandKind> CommandNamed(std::string_view name) {
  if (name == "arm") return intaglio_COMMAND_ARM;
  if (name == "pause") return intaglio_COMMAND_PAUSE;
  if (name == "resume") return intaglio_COMMAND_RESUME;
  if (name == "cancel") return intaglio_COMMAND_CANCEL;
  if (name == "speed") return intaglio_COMMAND_SPEED;
  if (name == "move") return intaglio_COMMAND_MOVE;
  return std::nullopt;
}

Result<PostedCommand> ReadCommand(intaglio_JobCommandKind kind, const std::string& body) {
  PostedCommand command{.order = {.kind = kind, .basis = intaglio_ARM_BY_PERSON},
                        .token = {}};
  client::JobOrder& order = command.order;
  if (kind == intaglio_COMMAND_ARM) {
    const auto arm = BodyOf<ArmRequest>(body);
    if (!arm) return Fail(ErrorCode::kInvalidValue, "the body is no ArmRequest");
    order.accept_breakage = arm->accept_breakage();
    command.token = arm->token();
  } else if (kind == intaglio_COMMAND_RESUME) {
    const auto resume = BodyOf<ResumeRequest>(body);
    if (!resume) return Fail(ErrorCode::kInvalidValue, "the body is no ResumeRequest");
    order.accept_breakage = resume->accept_breakage();
    order.from_point = resume->from_point();
    order.fire_uncertain = resume->fire_uncertain();
    command.token = resume->token();
  } else if (kind == intaglio_COMMAND_SPEED) {
    const auto speed = BodyOf<SpeedRequest>(body);
    if (!speed) return Fail(ErrorCode::kInvalidValue, "the body is no SpeedRequest");
    order.speed_percent = speed->percent();
  } else if (kind == intaglio_COMMAND_MOVE) {
    const auto move = BodyOf<MoveRequest>(body);
    if (!move) return Fail(ErrorCode::kInvalidValue, "the body is no MoveRequest");
    order.before_job_uid = move->before();
  }
  return command;
}

}  // namespace intaglio::console
