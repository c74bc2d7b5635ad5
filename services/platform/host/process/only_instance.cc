#include "services/platform/host/process/only_instance.h"

#include <fmt/format.h>

#include <thread>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"

namespace intaglio::host {
namespace {

using bus::View;
using namespace std::chrono_literals;

std::chrono::nanoseconds Now() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

// Present processes are discovered within some 50 ms on one computer, and on a network
// with identities, where a handshake comes first, within a second.
std::chrono::nanoseconds WatchPeriodOf(const bus::BusOptions& options) {
  return options.interface == "lo" && options.security.empty() ? 250ms : 1500ms;
}

// Stopping, not at fault: a service with a fault keeps running, and a process that starts
// would give way to it.
int End(ServiceHost& host, const std::string& code, const std::string& text, int result) {
  host.SetHealth(intaglio_HEALTH_STOPPING, {}, text);
  host.RaiseAlarm(intaglio_ALARM_FAULT, code, text);
  return result;
}

}  // namespace

OnlyInstance::OnlyInstance(ServiceHost& host, intaglio_ServiceRole role,
                           Starting starting)
    : host_(host),
      role_(role),
      health_(host.bus(), bus::kServiceHealth, bus::RolePartition(host.bus().role())),
      watch_(host.instance(), Now(), WatchPeriodOf(host.bus().options()), starting) {}

void OnlyInstance::Take() {
  const std::string& cell = host_.bus().options().cell;
  health_.TakeAll([&](const intaglio_ServiceHealth& sample, const bus::SampleOrigin& o) {
    const std::string instance(View(sample.instance));
    if (!IsOwnHealth(sample, o)) return;
    if (!o.alive) return watch_.Lose(instance);
    const bool same = role_ == intaglio_ROLE_JOB_SERVICE || View(sample.cell) == cell;
    if (sample.role != role_ || !same) return;
    watch_.Receive({instance, std::string(View(sample.host)), sample.pid, sample.state},
                   Now());
  });
}

bool OnlyInstance::AwaitTurn() {
  while (!host_.stopping()) {
    Take();
    const auto verdict = watch_.JudgeStart(Now());
    if (verdict != RivalWatch::Verdict::kWait)
      return verdict == RivalWatch::Verdict::kEnd;
    host_.KeepAlive();
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

bool OnlyInstance::MustEnd() {
  Take();
  return watch_.JudgeWork(Now()) == RivalWatch::Verdict::kEnd;
}

int OnlyInstance::EndAsSecond(const std::string& name) {
  const Rival& rival = watch_.rival();
  const std::string& cell = host_.bus().options().cell;
  const std::string of =
      role_ == intaglio_ROLE_JOB_SERVICE ? "this bus" : "cell '" + cell + "'";
  return End(
      host_, "second_instance",
      fmt::format("{} is served by another {} on {}, process {} ({}); this process "
                  "ends",
                  of, name, rival.host, rival.pid, rival.instance),
      kExitSecond);
}

int EndTakenOver(ServiceHost& host, const std::string& name) {
  return End(host, "taken_over",
             "another " + name + " has taken over this machine; this process ends",
             kExitTakenOver);
}

}  // namespace intaglio::host
