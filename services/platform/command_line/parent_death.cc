#include "services/platform/command_line/parent_death.h"

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace intaglio::command_line {

void AddParentFlag(Command app, int& starter) {
  app.AddFlag("--die-with-parent{-1}", starter,
              "end when the process that started this one ends; =PID names that process, "
              "which may have ended already");
}

bool EndWithParent(int starter, pid_t parent) {
  if (starter == 0) return true;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  return getppid() == (starter > 0 ? starter : parent);
}

}  // namespace intaglio::command_line
