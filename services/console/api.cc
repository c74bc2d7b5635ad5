#include "services/console/api.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <iostream>
#include <optional>
#include <set>

#include "services/client/shop/job_record.h"
#include "services/console/answers/json_response.h"
#include "services/console/answers/posted_command.h"
#include "services/console/shop_history.h"
#include "services/job/files/json_text.h"

namespace intaglio::console {
namespace {

constexpr std::string_view kApi = "/api/v1/";
constexpr std::string_view kJobs = "jobs/";

web::Response Unknown() {
  return ErrorResponse(404, "there is nothing at this path: docs/console.md has all");
}

/// Another method than those that the path has, or a path that nothing is at.
web::Response Unasked(const std::string& path) {
  const std::string methods = MethodsOf(path);
  if (methods.empty()) return Unknown();
  web::Response response = ErrorResponse(405, "this path has " + methods + " alone");
  response.allow = methods;
  return response;
}

constexpr char kNobody[] = "nobody is logged in here: log in";
constexpr char kNoUsers[] =
    "nobody can log in: on the console's computer, `intaglio console user add NAME "
    "--role operator`; its log has the reason";

ConsoleAudit EntryOf(const Visitor& visitor, const web::Caller& caller,
                     const std::string& request, int status) {
  ConsoleAudit entry;
  entry.set_name(visitor.name);
  if (!visitor.session.empty()) entry.set_role(access::NameOf(visitor.role));
  entry.set_address(caller.address);
  entry.set_request(request);
  entry.set_status(static_cast<std::uint32_t>(status));
  return entry;
}

constexpr char kManyFiles[] = "too many files are being read: try again";
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
  if (bytes.error().code == ErrorCode::kRefused)
    return ErrorResponse(503, bytes.error().message);
  return ErrorResponse(StatusOf(bytes.error().code), bytes.error());
}

std::optional<std::uint32_t> NumberIn(const web::Request& request, const char* name) {
  const auto found = request.target.query.find(name);
  if (found == request.target.query.end()) return 0;
  std::uint32_t number = 0;
  const char* end = found->second.data() + found->second.size();
  const auto [read, error] = std::from_chars(found->second.data(), end, number);
  return error == std::errc() && read == end ? std::optional(number) : std::nullopt;
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

std::string Api::AnswerMessage(web::PeerId page, const web::Caller& caller,
                               const std::string& text) {
  const auto request = ParseConsoleRequest(text);
  const auto visitor = access_.VisitorOf(caller);
  if (!visitor) return LineOf(ErrorOf(401, kNobody));
  if (!request) return LineOf(ErrorOf(request.error()));
  if (request->has_stop()) {
    const StopAnswer stop = desk_.Press(request->stop().reason());
    audit_.Add(EntryOf(*visitor, caller, "WebSocket stop", stop.sent() ? 200 : 500));
    return LineOf(stop);
  }
  if (!request->has_jog()) return LineOf(ErrorOf(400, "a request has a stop or a jog"));
  const auto refused = Jog(page, caller, *visitor, request->jog());
  return refused ? LineOf(*refused) : "";
}

std::optional<ConsoleError> Api::Jog(web::PeerId page, const web::Caller& caller,
                                     const Visitor& visitor, const JogRequest& request) {
  // Who has lost the right lets go: that always passes.
  const bool moves = !request.kind().empty();
  const auto refusal =
      moves ? access_.WhyNot(Right::kCharge, visitor) : std::optional<Refusal>();
  const auto passed =
      refusal ? Result<bool>(Fail(ErrorCode::kRefused, refusal->message))
              : jogs_.Pass(page, request, visitor.name, JogDesk::Clock::now());
  if (passed && !*passed) return std::nullopt;
  if (passed) access_.log_ins().Act(visitor.session, access::LogIns::Clock::now());
  const int status = passed ? 200 : refusal ? refusal->status : 400;
  if (moves) {
    audit_.Add(EntryOf(visitor, caller,
                       fmt::format("WebSocket jog {} {}", request.cell(), request.kind()),
                       status));
  }
  if (passed) return std::nullopt;
  ConsoleError error = ErrorOf(passed.error());
  if (refusal) error.set_code(refusal->code);
  return error;
}

std::optional<Visitor> Api::Admit(const web::Request& request, web::Reply& reply) {
  const Route* route = FindRoute(request.method, request.target.path);
  const auto visitor = access_.VisitorOf(request.caller);
  if (!visitor || route == nullptr) {
    reply(visitor ? Unasked(request.target.path) : ErrorResponse(401, kNobody));
    return std::nullopt;
  }
  if (request.method == "POST") reply = Audited(request, *visitor, std::move(reply));
  if (request.method == "POST" || request.target.query.contains("here"))
    access_.log_ins().Act(visitor->session, access::LogIns::Clock::now());
  const auto refusal = access_.WhyNot(route->right, *visitor);
  if (!refusal) return visitor;
  CommandAnswer answer;
  answer.set_code(refusal->code);
  answer.set_message(refusal->message);
  reply(JsonResponse(refusal->status, answer));
  return std::nullopt;
}

void Api::Answer(const web::Request& request, web::Reply reply) {
  const Route* route = FindRoute(request.method, request.target.path);
  if (route != nullptr && route->right == Right::kOpen) return LogIn(request, reply);
  if (const auto visitor = Admit(request, reply))
    Dispatch(request, *visitor, std::move(reply));
}

std::shared_ptr<web::BodySink> Api::Receive(const web::Request& request,
                                            std::uint64_t body_bytes, web::Reply reply) {
  if (!Admit(request, reply)) return nullptr;
  if (const auto job = JobOfPhotoPath(request.target.path))
    return photos_.Receive(*job, request, body_bytes, reply);
  if (const auto path = ParseSubmissionPath(request.target.path))
    return submit_.Receive(*path, request, body_bytes, std::move(reply));
  reply(Unknown());
  return nullptr;
}

void Api::Dispatch(const web::Request& request, const Visitor& visitor,
                   web::Reply reply) {
  const std::string& path = request.target.path;
  if (path == "/metrics") {
    return desk_.Order([this, reply](ShopDesk& desk) {
      reply(web::TextResponse(200, "text/plain; version=0.0.4; charset=utf-8",
                              desk.Metrics() + webhooks_.Metrics()));
    });
  }
  const std::string rest = path.substr(kApi.size());
  if (rest == "session" || rest == "logout" || rest == "charge")
    return AnswerSession(rest, visitor, reply);
  const auto machine = SplitMachinePath(path);
  if (machine && machine->part == "reset")
    return Reset(machine->cell, request, visitor, std::move(reply));
  if (machine) return teach_.Answer(*machine, request, std::move(reply));
  if (const auto job = JobOfPhotoPath(path)) return photos_.AnswerGet(*job, reply);
  if (request.method == "GET") return AnswerGet(rest, request, std::move(reply));
  AnswerPost(rest, request, std::move(reply));
}

web::Reply Api::Audited(const web::Request& request, const Visitor& visitor,
                        web::Reply reply) {
  return [&audit = audit_,
          entry = EntryOf(visitor, request.caller,
                          request.method + " " + request.target.path, 0),
          reply = std::move(reply)](const web::Response& response) mutable {
    entry.set_status(static_cast<std::uint32_t>(response.status));
    audit.Add(entry);
    reply(response);
  };
}

void Api::LogIn(const web::Request& request, const web::Reply& reply) {
  const auto given = BodyOf<LogInRequest>(request.body);
  if (!given) return reply(ErrorResponse(400, "the body is no LogInRequest"));
  Visitor visitor;
  visitor.name = given->name();
  const auto answer = Audited(request, visitor, reply);
  const bool taken = log_ins_.Add(
      [&desk_access = access_, answer, given = *given, address = request.caller.address] {
        const auto opened = desk_access.log_ins().LogIn(
            given.name(), given.password(), address, access::LogIns::Clock::now());
        if (!opened) {
          const Error& error = opened.error();
          if (error.code == ErrorCode::kTimedOut || error.code == ErrorCode::kRefused) {
            return answer(ErrorResponse(error.code == ErrorCode::kTimedOut ? 429 : 401,
                                        error.message));
          }
          std::cerr << "log-in: " << error.message << "\n";
          return answer(ErrorResponse(503, kNoUsers));
        }
        const access::Session& session = opened->session;
        web::Response response = JsonResponse(
            200, desk_access.SessionOf({session.id, session.name, session.role, false}));
        response.token = opened->token;
        answer(response);
      });
  if (!taken) answer(ErrorResponse(503, "too many log in at once: try again"));
}

void Api::AnswerSession(const std::string& path, const Visitor& visitor,
                        const web::Reply& reply) {
  if (path == "charge") {
    access_.TakeCharge(visitor);
    desk_.Order([](ShopDesk& desk) { desk.LetGo(); });
  }
  web::Response response = JsonResponse(200, access_.SessionOf(visitor));
  if (path == "logout") {
    access_.log_ins().LogOut(visitor.session);
    response.token = "";
  }
  reply(response);
}

void Api::AnswerGet(const std::string& path, const web::Request& request,
                    web::Reply reply) {
  if (path == "status") {
    return desk_.Order(
        [reply](ShopDesk& desk) { reply(JsonResponse(200, desk.Status())); });
  }
  if (path == "jobs") {
    return desk_.Order([reply](ShopDesk& desk) {
      reply(JsonResponse(200, client::JobListOf(desk.client().jobs(),
                                                std::chrono::system_clock::now())));
    });
  }
  if (const auto submission = ParseSubmissionPath(request.target.path))
    return submit_.AnswerGet(*submission, std::move(reply));
  if (path == "choices") return submit_.AnswerChoices(std::move(reply));
  if (const auto form = HistoryFormOf(path)) {
    const bool taken = clouds_.Ask([this, form, query = request.target.query, reply] {
      reply(HistoryResponse(*form, database_, query));
    });
    return taken ? void() : reply(ErrorResponse(503, kManyFiles));
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
  if (file == nullptr && !part.empty() && part != "plan" && !CloudReader::IsPart(part))
    return reply(Unknown());
  if (part.empty()) {
    return desk_.Order([job, reply](ShopDesk& desk) {
      const auto found = desk.client().Find(job);
      reply(found ? JsonResponse(200, client::JobRecordOf(*found))
                  : ErrorResponse(404, found.error()));
    });
  }
  find_job_(job, [this, part, file, from, reply](const Result<FoundJob>& found) {
    if (!found) {
      const Error& error = found.error();
      return reply(ErrorResponse(StatusOf(error.code, 404), error));
    }
    const char* type = file != nullptr ? file->content_type : kBytes;
    const auto answer = [reply, type](const Result<CloudReader::Bytes>& bytes) {
      reply(BytesResponse(bytes, type));
    };
    const bool taken =
        file != nullptr  ? clouds_.AskForFile(found->folder / file->file, answer)
        : part == "plan" ? clouds_.AskForPlan(found->folder, answer)
                         : clouds_.AskForPart(part, found->folder, from, answer);
    if (!taken) reply(ErrorResponse(503, kManyFiles));
  });
}

void Api::Reset(const std::string& cell, const web::Request& request,
                const Visitor& visitor, web::Reply reply) {
  const auto asked = BodyOf<ResetRequest>(request.body);
  if (!asked) return reply(ErrorResponse(400, "the body is no ResetRequest"));
  const std::set<std::string> presses(asked->presses().begin(), asked->presses().end());
  desk_.Order([cell, presses, person = visitor.name, reply](ShopDesk& desk) {
    desk.Reset(cell, presses, person, [reply](int status, const CommandAnswer& answer) {
      reply(JsonResponse(status, answer));
    });
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
  if (!command) return reply(ErrorResponse(400, command.error()));
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
