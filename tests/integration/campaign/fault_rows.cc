#include "tests/integration/campaign/fault_rows.h"

namespace intaglio::campaign {

const std::vector<FaultRow>& FaultRows() {
  using By = FaultRow::By;
  static const std::vector<FaultRow> rows = {
      {"hold", By::kPanel, "hold"},
      {"reset", By::kPanel, "reset", "", true, true},
      {"emergency-stop", By::kPanel, "estop press", "estop release", true, true, true},
      {"limit", By::kPanel, "limit", "", true, true},
      {"alarm", By::kPanel, "alarm", "", true, true},
      {"error", By::kPanel, "error"},
      {"door", By::kPanel, "door open", "door close", true, false, true},
      {"key", By::kPanel, "key off", "key on", true, false, true},
      {"power-cycle", By::kPower, "", "", true, true, true},
      {"stop", By::kCommand, "stop", "stop --reset", true, false, true},
      {"pause", By::kCommand, "pause 1", "", true, false, true},
      {"unplug", By::kPanel, "unplug", "plug", false, false, true},
      {"kill-job-service", By::kKill, "intaglio-job-service", "", false, false, true},
      {"kill-discretizer", By::kKill, "intaglio-discretizer", "", false, false, true},
      {"kill-sorter", By::kKill, "intaglio-sorter", "", false, false, true},
      {"kill-marker", By::kKill, "intaglio-marker", "", false, false, true},
      {"kill-synchronizer", By::kKill, "intaglio-synchronizer", "", false},
      {"kill-motion-bridge", By::kKill, "intaglio-motion-bridge", "", false},
      {"kill-all", By::kKill, "intaglio-up", "", false, false, true},
  };
  return rows;
}

}  // namespace intaglio::campaign
