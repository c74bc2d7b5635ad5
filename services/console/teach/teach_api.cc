#include "services/console/teach/teach_api.h"

#include <google/protobuf/util/json_util.h>

#include <charconv>
#include <utility>

#include "services/console/answers/json_response.h"
#include "services/console/teach/machine_teaching.h"
#include "services/console/teach/test_jobs.h"

namespace intaglio::console {
namespace {

std::string QueryOf(const web::Request& request, const char* name) {
  const auto found = request.target.query.find(name);
  return found == request.target.query.end() ? "" : found->second;
}

}  // namespace

std::optional<MachinePath> SplitMachinePath(std::string_view path) {
  constexpr std::string_view kBegin = kMachinesPath;
  if (!path.starts_with(kBegin)) return std::nullopt;
  path.remove_prefix(kBegin.size());
  const auto slash = path.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  return MachinePath{std::string(path.substr(0, slash)),
                     std::string(path.substr(slash + 1))};
}

void TeachApi::Answer(const MachinePath& path, const web::Request& request,
                      web::Reply reply) {
  const auto machine = jogs_.Machine(path.cell, JogDesk::Clock::now());
  if (!machine) return reply(ErrorResponse(404, machine.error()));
  if (request.method == "POST")
    return Submit(*machine, path.part, request, std::move(reply));
  if (path.part == "zero_move")
    return AnswerZeroMove(*machine, request, std::move(reply));
  Read(
      [machine = *machine, reply] {
        const auto teaching = TeachingOf(machine);
        reply(teaching
                  ? JsonResponse(200, *teaching)
                  : ErrorResponse(StatusOf(teaching.error().code), teaching.error()));
      },
      reply);
}

void TeachApi::Submit(const client::MachineView& machine, const std::string& part,
                      const web::Request& request, web::Reply reply) {
  TestJobRequest asked;
  const auto read = google::protobuf::util::JsonStringToMessage(request.body, &asked);
  if (!read.ok()) return reply(ErrorResponse(400, "the body is no TestJobRequest"));
  const TestKind kind = part == "focus" ? TestKind::kFocus : TestKind::kPulse;
  submit_.SubmitWritten(
      asked.id(),
      [machine, kind, asked,
       stage_per_glass = stage_per_glass_](const std::filesystem::path& folder) {
        return WriteTestJob(machine, kind, asked, stage_per_glass, folder);
      },
      std::move(reply));
}

void TeachApi::AnswerZeroMove(const client::MachineView& machine,
                              const web::Request& request, web::Reply reply) {
  const std::string text = QueryOf(request, "first");
  std::uint32_t first = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), first);
  if (error != std::errc() || end != text.data() + text.size())
    return reply(ErrorResponse(400, "first: give the number of a crack, from 1"));
  find_job_(
      QueryOf(request, "job"), [this, machine, first, reply](Result<FoundJob> found) {
        if (!found) return reply(ErrorResponse(404, found.error()));
        Read(
            [this, machine, first, reply, job = std::move(*found)] {
              auto move = ZeroMoveOf(machine, job.folder, first, stage_per_glass_);
              if (!move)
                return reply(ErrorResponse(StatusOf(move.error().code), move.error()));
              move->set_job(job.number);
              reply(JsonResponse(200, *move));
            },
            reply);
      });
}

void TeachApi::Read(std::function<void()> work, const web::Reply& reply) {
  if (!disk_.Add(std::move(work)))
    reply(ErrorResponse(503, "too many profiles are read at once: try again"));
}

}  // namespace intaglio::console
