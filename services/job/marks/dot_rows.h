#pragma once

// How a scan head makes the dots of an image in rows, each in one sweep of its mirrors.

#include <optional>
#include <string>

#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/mark.pb.h"
#include "services/job/marks/mark_shapes.h"

namespace intaglio {

/// None: the item has no dots, or each is made by itself. `item` with its defaults. A gap
/// is jumped when its jump, with run-out and run-in, takes less time than passing it. A
/// row takes half a second at most, for a stop breaks no more than one; on a web it is an
/// eighth of the field long, for the field has to hold it whole.
std::optional<DotRows> DotRowsOf(const MarkItem& item, bool on_web,
                                 const MachineSpec& machine);

/// How the dots of this item are made, for a person; empty: it has none.
std::string DotModeText(const MarkItem& item, const MachineSpec& machine);

/// Adds a note on each item whose dots are made each by itself, where the job leaves that
/// to the machine. `job` with its defaults.
void NoteDotModes(const JobSpec& job, const MachineSpec& machine, Warnings& warnings);

}  // namespace intaglio
