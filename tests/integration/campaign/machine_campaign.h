#pragma once

// Faults at seeded random instants of jobs on one machine of the table (machine_rows.h):
// each run has a shop and a machine of its own and one fault (fault_rows.h), the faults
// in turn. Behind a fault that needs a person nothing moves, turns or is lit before a
// person arms anew, and where the tool's place may be lost, not before the zero was set.
// Then the job goes on to its end, and record and journal are compared item by item.

#include <string>

namespace intaglio::campaign {

struct MachineCampaign {
  std::string machine;
  std::string fault;  ///< of one row alone; empty: all in turn
  int runs = 3;
  unsigned seed = 1;
  bool keep = false;  ///< the folders of good runs, too
};

/// Names of the rows, separated by spaces.
std::string MachineNames();
/// Prints each run and a row of the table; the exit code of the program. 2: there is no
/// such machine or fault.
int RunMachineCampaign(const MachineCampaign& campaign);

}  // namespace intaglio::campaign
