#include "services/console/teach/teach_api.h"

#include <utility>

#include "services/console/answers/json_response.h"
#include "services/console/teach/machine_teaching.h"

namespace intaglio::console {
namespace {

constexpr char kManyProfiles[] = "too many profiles are read at once: try again";

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

void TeachApi::Answer(const MachinePath& path, web::Reply reply) {
  const auto machine = jogs_.Machine(path.cell, JogDesk::Clock::now());
  if (!machine) return reply(ErrorResponse(404, machine.error()));
  const bool taken = disk_.Add([machine = *machine, reply] {
    const auto teaching = TeachingOf(machine);
    reply(teaching ? JsonResponse(200, *teaching)
                   : ErrorResponse(StatusOf(teaching.error().code), teaching.error()));
  });
  if (!taken) reply(ErrorResponse(503, kManyProfiles));
}

}  // namespace intaglio::console
