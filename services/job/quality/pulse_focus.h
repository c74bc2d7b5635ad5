#pragma once

#include <string>

#include "engrave/core/warning.h"
#include "proto/machine.pb.h"
#include "proto/material.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// PulseFocusRecord.condition: whether a pulse makes a crack by the condition of the
/// source, that glass about its focus is heated above its thermal strength and stays
/// below its melting point (Trochimczuk 2008 ch. 5.2).
inline constexpr char kCrackConditionMet[] = "met";
/// The heat reaches the thermal strength nowhere outside of the spot, or the pulse has
/// less energy than the surface of its crack.
inline constexpr char kPulseTooWeak[] = "too_weak";
/// Glass melts as far as the crack should reach, or before it reaches its strength.
inline constexpr char kPulseMelts[] = "melts";
inline constexpr char kConditionNotKnown[] =
    "not_known";  ///< `unknown` names what is missing

/// The focus of a machine's lens in a glass, and what a pulse does there
/// (engrave/optics/pulse_focus.h, focus_heat.h), as far as profile and glass are known.
/// `energy_ratio`: of the machine's largest pulse, of which the profile has the crack;
/// > 0, up to 1.
PulseFocusRecord PulseFocusOf(const MaterialRecord& glass,
                              const OpticalValuesRecord& optics, const LaserHead& laser,
                              const MachineLens& lens, double energy_ratio = 1);

/// Describes the largest pulse of a job; without a condition where its lens is not known.
PulseFocusRecord PulseFocusOf(const FrozenJob& job);

/// The condition in words, "met: ...", "not known, for want of tensile strength".
std::string CrackConditionText(const PulseFocusRecord& focus);

/// Pulses of the job that do not meet the condition: the weakest where it is too weak,
/// the strongest where it melts. What is not known is no warning.
Warnings PulseWarningsOf(const FrozenJob& job);

}  // namespace intaglio
