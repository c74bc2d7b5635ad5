#pragma once

// What happens to a machine or to its shop in the middle of a job, and what has to follow
// (docs/jobs.md, arming; docs/machines/grbl.md): one row each, whatever the machine.

#include <string>
#include <vector>

namespace intaglio::campaign {

struct FaultRow {
  enum class By {
    kPanel,    ///< a line at the controller's panel
    kKill,     ///< SIGKILL of a process; "intaglio-up" is the one that started all
    kCommand,  ///< words of `intaglio`
    kPower,    ///< the machine's mains switch
  };
  const char* name;
  By by;
  std::string act;             ///< empty: kPower
  std::string set_right = {};  ///< by the same way, some time later
  bool needs_person = true;    ///< nothing goes on by itself
  bool loses_place = false;    ///< of a controller that counts steps
  bool of_scan_head = false;   ///< a scan head has it, too
};

/// Those that end the process which has the line to the controller, or all, need a person
/// where the controller has no number of its power-up (MachineRow).
const std::vector<FaultRow>& FaultRows();

}  // namespace intaglio::campaign
