#include "services/console/api.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "services/client/shop/job_record.h"
#include "services/job/json_text.h"

namespace intaglio::console {
namespace {

constexpr std::string_view kApi = "/api/v1/";
constexpr std::string_view kJobs = "jobs/";

web::Response JsonResponse(int status, const google::protobuf::Message& message) {
  auto json = JsonTextOf(message);
  if (json) return web::TextResponse(status, "application/json", std::move(*json));
  return web::TextResponse(500, "text/plain; charset=utf-8", json.error().message + "\n");
}

web::Response ErrorResponse(int status, std::string message) {
  ConsoleError error;
  error.set_message(std::move(message));
  return JsonResponse(status, error);
}

web::Response Unknown() {
  return ErrorResponse(404, "there is nothing at this path: docs/console.md has all");
}

constexpr char kBytes[] = "application/octet-stream";

/// What a job's folder has of it, by the part of the path; nothing else is read there.
struct JobFile {
  std::string_view part;
  const char* file;
  const char* content_type;
};
constexpr JobFile kJobFiles[] = {{"report", "report.json", "application/json"},
                                 {"picture", "customer.png", "image/png"},
                                 {"views", "views.png", "image/png"}};

const JobFile* JobFileOf(std::string_view part) {
  const auto* found = std::find_if(std::begin(kJobFiles), std::end(kJobFiles),
                                   [&](const JobFile& one) { return one.part == part; });
  return found == std::end(kJobFiles) ? nullptr : found;
}

web::Response BytesResponse(const Result<CloudReader::Bytes>& bytes,
                            const char* content_type) {
  if (bytes) return {200, content_type, *bytes};
  return ErrorResponse(bytes.error().code == ErrorCode::kNotFound ? 404 : 500,
                       bytes.error().message);
}

std::optional<std::uint32_t> NumberIn(const web::Request& request, const char* name) {
  const auto found = request.target.query.find(name);
  if (found == request.target.query.end()) return 0;
  std::uint32_t number = 0;
  const char* end = found->second.data() + found->second.size();
  const auto [read, error] = std::from_chars(found->second.data(), end, number);
  return error == std::errc() && read == end ? std::optional(number) : std::nullopt;
}

/// The message in a body; nullopt: another one, a field of another name among it.
template <typename Message>
std::optional<Message> BodyOf(const std::string& body) {
  Message message;
  const bool read =
      body.empty() || google::protobuf::util::JsonStringToMessage(body, &message).ok();
  return read ? std::optional(message) : std::nullopt;
}

/// What a command of this name asks for; nullopt: there is no such one.
std::optional<intaglio_JobCommandKind> CommandNamed(std::string_view name) {
  if (name == "arm") return intaglio_COMMAND_ARM;
  if (name == "pause") return intaglio_COMMAND_PAUSE;
  if (name == "resume") return intaglio_COMMAND_RESUME;
  if (name == "cancel") return intaglio_COMMAND_CANCEL;
  if (name == "speed") return intaglio_COMMAND_SPEED;
  return std::nullopt;
}

/// A command with what its body says; `token` of those that let a machine fire.
struct PostedCommand {
  client::JobOrder order;
  std::string token;
};

/// kInvalidValue: the body is not that of this command.
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
  }
  return command;
}

/// A body that is no StopRequest prevents no stop.
std::string ReasonIn(const std::string& body) {
  const auto request = BodyOf<StopRequest>(body);
  return request ? request->reason() : std::string();
}

/// "7" and "plan" of "7/plan".
std::pair<std::string, std::string> SplitJob(std::string_view path) {
  const auto slash = path.find('/');
  return {std::string(path.substr(0, slash)),
          slash == std::string_view::npos ? "" : std::string(path.substr(slash + 1))};
}

}  // namespace

Result<ConsoleRequest> ParseConsoleRequest(const std::string& text) {
  ConsoleRequest request;
  const auto parsed = google::protobuf::util::JsonStringToMessage(text, &request);
  if (parsed.ok()) return request;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("no ConsoleRequest: {}", parsed.ToString()));
}

std::string Api::AnswerMessage(const std::string& text) {
  const auto request = ParseConsoleRequest(text);
  ConsoleState state;
  ConsoleError error;
  if (!request) {
    error.set_message(request.error().message);
  } else if (!request->has_stop()) {
    error.set_message("a request has a stop");
  } else {
    *state.mutable_stop() = desk_.Press(request->stop().reason());
  }
  auto json = JsonTextOf(error, JsonLayout::kOneLine);
  if (state.has_stop()) json = JsonTextOf(state.stop(), JsonLayout::kOneLine);
  return json ? *json : std::string("{}");
}

void Api::Answer(const web::Request& request, web::Reply reply) {
  const std::string& path = request.target.path;
  if (path == "/metrics" && request.method == "GET") {
    return desk_.Order([reply](ShopDesk& desk) {
      reply(web::TextResponse(200, "text/plain; version=0.0.4; charset=utf-8",
                              desk.Metrics()));
    });
  }
  if (!path.starts_with(kApi)) return reply(Unknown());
  const std::string rest = path.substr(kApi.size());
  if (request.method == "GET") return AnswerGet(rest, request, std::move(reply));
  AnswerPost(rest, request, std::move(reply));
}

void Api::AnswerGet(const std::string& path, const web::Request& request,
                    web::Reply reply) {
  if (path == "status") {
    return desk_.Order(
        [reply](ShopDesk& desk) { reply(JsonResponse(200, desk.Status())); });
  }
  if (path == "jobs") {
    return desk_.Order([reply](ShopDesk& desk) {
      reply(JsonResponse(200, client::JobListOf(desk.client().jobs())));
    });
  }
  const auto from = NumberIn(request, "from");
  if (!from) return reply(ErrorResponse(400, "from: give a whole number"));
  if (!path.starts_with(kJobs)) return reply(Unknown());
  const auto [job, part] = SplitJob(std::string_view(path).substr(kJobs.size()));
  AnswerJob(job, part, *from, std::move(reply));
}

void Api::AnswerJob(const std::string& job, const std::string& part, std::uint32_t from,
                    web::Reply reply) {
  const JobFile* file = JobFileOf(part);
  if (file == nullptr && !part.empty() && part != "plan" && part != "made")
    return reply(Unknown());
  desk_.Order([this, job, part, file, from, reply](ShopDesk& desk) {
    const auto found = desk.client().Find(job);
    if (!found) return reply(ErrorResponse(404, found.error().message));
    if (part.empty()) return reply(JsonResponse(200, client::JobRecordOf(*found)));
    const std::filesystem::path folder = found->result_directory;
    const char* type = file != nullptr ? file->content_type : kBytes;
    const auto answer = [reply, type](const Result<CloudReader::Bytes>& bytes) {
      reply(BytesResponse(bytes, type));
    };
    const bool taken = file != nullptr  ? clouds_.AskForFile(folder / file->file, answer)
                       : part == "plan" ? clouds_.AskForPlan(folder, answer)
                                        : clouds_.AskForMade(folder, from, answer);
    if (!taken) reply(ErrorResponse(503, "too many files are being read: try again"));
  });
}

void Api::AnswerPost(const std::string& path, const web::Request& request,
                     web::Reply reply) {
  if (path == "stop") {
    // Before anything else, and not by way of the desk's thread.
    const StopAnswer sent = desk_.Press(ReasonIn(request.body));
    if (!sent.sent()) return reply(JsonResponse(500, sent));
    return desk_.Order([number = sent.number(), reply](ShopDesk& desk) {
      desk.AwaitConfirmation(number, [reply](const StopAnswer& answer) {
        reply(JsonResponse(200, answer));
      });
    });
  }
  if (!path.starts_with(kJobs)) return reply(Unknown());
  const auto job_and_name = SplitJob(std::string_view(path).substr(kJobs.size()));
  const std::string& job = job_and_name.first;  // clang captures no part of a binding
  if (job_and_name.second == "hold") {
    const auto hold = BodyOf<HoldRequest>(request.body);
    if (!hold) return reply(ErrorResponse(400, "the body is no HoldRequest"));
    return desk_.Order([job, block = hold->block(), reply](ShopDesk& desk) {
      const auto [status, answer] = desk.Hold(job, block);
      reply(JsonResponse(status, answer));
    });
  }
  const auto kind = CommandNamed(job_and_name.second);
  if (!kind) return reply(Unknown());
  const auto command = ReadCommand(*kind, request.body);
  if (!command) return reply(ErrorResponse(400, command.error().message));
  desk_.Order([job, command = *command, reply](ShopDesk& desk) {
    const auto answer = [reply](int status, const CommandAnswer& answered) {
      reply(JsonResponse(status, answered));
    };
    const auto ordered = command.order.kind;
    if (ordered == intaglio_COMMAND_ARM || ordered == intaglio_COMMAND_RESUME)
      desk.Fire(job, command.token, command.order, answer);
    else
      desk.Command(job, command.order, answer);
  });
}

}  // namespace intaglio::console
