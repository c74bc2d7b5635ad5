#include "services/cli/terminal/interrupt.h"

#include <signal.h>

#include <atomic>

namespace intaglio::cli {
namespace {
std::atomic<int> interrupts{0};
static_assert(std::atomic<int>::is_always_lock_free, "used in a signal handler");
}  // namespace

void CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupts.fetch_add(1); };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int Interrupts() { return interrupts.load(); }

}  // namespace intaglio::cli
