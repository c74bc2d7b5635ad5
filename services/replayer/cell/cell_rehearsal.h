#pragma once

// Has a synchronizer engrave once more what it engraved in a recording, alone on a bus of
// its own with a simulated laser, and compares what it reports now with what it reported
// in the recording (cell_comparison.h). Causes as in rehearsal.h. From one thread.

#include <filesystem>

#include "proto/machine.pb.h"
#include "services/replayer/rehearsal.h"

namespace intaglio::replayer {

/// The machine whose sessions are rehearsed, with the profile of the first engraving task
/// that moved it. kMissing: nothing was engraved in the recording.
Result<MachineSpec> MachineOf(const recording::McapReader& reader);

struct CellRehearsalOptions {
  std::filesystem::path laser_line;  ///< where the synchronizer connects to its laser
  std::filesystem::path results;     ///< folder for job folders; is there
  std::function<Status(FrozenJob& job)> change;  ///< may be null
};

/// As Rehearse().
Result<ReplayComparison> RehearseCell(bus::Bus& bus, const recording::McapReader& reader,
                                      const CellRehearsalOptions& options,
                                      const KeepOn& keep_on);

}  // namespace intaglio::replayer
