#include "services/client/shop/kept_process.h"

#include <fmt/format.h>

#include "engrave/core/try.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMaxEnds = 5;
constexpr auto kWithin = 60s;
// They are those of services/platform/host/process/only_instance.h.
constexpr int kExitSecond = 3, kExitTakenOver = 4;

}  // namespace

Error EndOf(const ChildProcess& process) {
  return {
      ErrorCode::kFault,
      fmt::format("{} has ended by itself (exit code {}); its last output:\n{}",
                  process.name(), process.exit_code().value_or(-1), process.LastOutput()),
      process.name()};
}

Result<KeptProcess> KeptProcess::Start(const ChildProcess::Command& command) {
  auto started = INTAGLIO_TRY(ChildProcess::Start(command));
  return KeptProcess(std::move(started));
}

Result<std::optional<std::string>> KeptProcess::Revive(
    std::chrono::steady_clock::time_point now) {
  if (process_.running()) return std::optional<std::string>();
  const int exit_code = process_.exit_code().value_or(-1);
  // Another process has its work: started again it would take it from that one.
  if (exit_code == kExitSecond || exit_code == kExitTakenOver) {
    return tl::unexpected(EndOf(process_));
  }
  ends_.push_back(now);
  while (now - ends_.front() > kWithin) ends_.pop_front();
  if (ends_.size() >= kMaxEnds) return tl::unexpected(EndOf(process_));
  auto started = INTAGLIO_TRY(ChildProcess::Start(process_.command()));
  process_ = std::move(started);
  return std::optional(fmt::format(
      "{} has ended unexpectedly (exit code {}) and was restarted as process {}",
      process_.name(), exit_code, process_.pid()));
}

}  // namespace intaglio::client
