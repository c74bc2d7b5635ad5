#pragma once

// What the laser reported of its pulses, from the journal.

#include <cstdint>
#include <span>

#include "engrave/formats/journal_file.h"
#include "proto/report.pb.h"
#include "services/job/machine/pulse_energies.h"

namespace intaglio::client {

/// Energies of the pulses that the laser measured, against what was commanded: mean,
/// standard deviation, and the one furthest off. Of points of one energy into
/// pulse_energy, else one for each energy into pulse_energies. `history` by place in the
/// order.
void AddPulseEnergies(std::span<const formats::PointHistory> history,
                      const PointEnergies& energies, JobReport& report);

/// The pulses of the points that were fired, made or missed: `per_point` each.
void CountPulses(std::span<const formats::PointHistory> history, std::uint32_t per_point,
                 JobReport& report);

/// Missed pulses by channel, into missed_by_channel. A pulse that two channels missed
/// counts for both.
void AddMisses(std::span<const formats::PointHistory> history, JobReport& report);

}  // namespace intaglio::client
