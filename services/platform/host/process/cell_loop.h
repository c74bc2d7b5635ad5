#pragma once

// The life of a service that fires the laser of one machine, the synchronizer or the
// marker, from its first turn to its last.

#include <array>
#include <chrono>
#include <string>

#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/patience.h"
#include "services/platform/host/process/poll_loop.h"
#include "services/platform/host/process/service_host.h"

namespace intaglio::host {

// A job that is armed before the controller answers has to be armed again, because key
// and door were not watched. So the first jobs wait a moment for it; on a busy computer
// longer, because whatever stands for the controller is late there, too (patience.h).
inline constexpr std::chrono::seconds kControllerTime{2};
// The longest time between two turns, of a cell that works and of one that rests: both
// turn at once for a message or a frame of the controller.
inline constexpr std::chrono::milliseconds kTurnTime{5}, kRestingTurnTime{20};
// Time for the shutters to close when the service is stopped.
inline constexpr std::chrono::seconds kStopTime{3};

/// Turns `cell` until the host stops or a newer host has taken the machine. Returns the
/// exit code of the process. `name` is the kind of service, "synchronizer".
///
/// Cell has AttachTo(PollLoop&), Turn(now), watches() (its controller answers), rests()
/// (it has no job, and nothing is moved or lit by hand), Stop(), stopped(), taken_over(),
/// line_fd() of its controller and journal_fd().
template <typename Cell>
int RunCellService(ServiceHost& host, const std::string& name, Cell& cell) {
  const auto now = [] { return std::chrono::steady_clock::now().time_since_epoch(); };
  PollLoop loop(host.bus());
  cell.AttachTo(loop);
  Patience patience(kControllerTime);
  bool ready = false;
  const auto turn = [&] {
    cell.Turn(now());
    if (!ready && (cell.watches() || patience.IsUp())) {
      ready = true;
      host.SetHealth(intaglio_HEALTH_READY);
    }
    host.KeepAlive();
    loop.Wait(std::array{cell.line_fd(), cell.journal_fd()},
              cell.watches() && cell.rests() ? kRestingTurnTime : kTurnTime);
  };
  while (!host.stopping() && !cell.taken_over()) turn();
  if (cell.taken_over()) return EndTakenOver(host, name);
  cell.Stop();
  const auto end = now() + kStopTime;
  while (!cell.stopped() && !cell.taken_over() && now() < end) turn();
  // What the last turn queued, the lamp off among it, is sent by the next.
  for (int i = 0; i < 2; ++i) turn();
  return 0;
}

}  // namespace intaglio::host
