#pragma once

// Several pulses a point: of a head that jumps and dwells
// (head_over_block.jump_and_dwell) at a laser whose pulses have a frequency
// (bjjcz_board.point_frequency_hz). A point is one crack, however many make it.

#include <cstdint>
#include <string>

#include "proto/machine.pb.h"

namespace intaglio {

/// How long a board may take for a point that lies across the field, with its delay: it
/// ends what it has without a host, so a list is short.
inline constexpr double kMaxBoardPointSeconds = 0.14;

/// The pulses in its dwell_s, 1 at least; 1 of any other machine.
std::uint32_t PulsesOfDwell(const MachineSpec& machine);

/// How long the laser is on for so many; where its pulses have no frequency, dwell_s.
double DwellSecondsOf(const MachineSpec& machine, std::uint32_t pulses);

/// Of a point that lies across the field, with its jump and delay.
double LongestPointSeconds(const MachineSpec& machine, double dwell_s);

/// Why the machine cannot make a point by so many pulses, as the end of a sentence, with
/// what to do; empty: it can. The dwell is in whole tens of microseconds, and of another
/// one more or fewer pulses would come.
std::string WhyNotSoManyPulses(const MachineSpec& machine, std::uint32_t pulses);

}  // namespace intaglio
