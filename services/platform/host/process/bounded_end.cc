#include "services/platform/host/process/bounded_end.h"

#include <signal.h>
#include <unistd.h>

#include <string_view>

namespace intaglio::host {
namespace {

volatile sig_atomic_t code_at_end = 0;

void End(int) {
  constexpr std::string_view kText =
      "the end of this service hangs in the DDS library: the process is ended\n";
  (void)!write(STDERR_FILENO, kText.data(), kText.size());
  _exit(code_at_end);
}

}  // namespace

void EndWithin(std::chrono::seconds time, int exit_code) {
  code_at_end = exit_code;
  struct sigaction action = {};
  action.sa_handler = &End;
  sigaction(SIGALRM, &action, nullptr);
  alarm(static_cast<unsigned>(time.count()));
}

}  // namespace intaglio::host
