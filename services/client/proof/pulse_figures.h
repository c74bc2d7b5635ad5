#pragma once

// What the laser reported of its pulses, from the journal.

#include <span>

#include "engrave/formats/journal_file.h"
#include "proto/report.pb.h"

namespace intaglio::client {

/// Energies of the pulses that the laser measured, against `commanded_mj`: mean, standard
/// deviation, and the one furthest off. `history` by place in the order.
PulseEnergyReport PulseEnergiesOf(std::span<const formats::PointHistory> history,
                                  double commanded_mj);

/// Missed pulses by channel, into missed_by_channel. A pulse that two channels missed
/// counts for both.
void AddMisses(std::span<const formats::PointHistory> history, JobReport& report);

}  // namespace intaglio::client
