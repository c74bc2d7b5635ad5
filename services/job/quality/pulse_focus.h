#pragma once

#include "proto/machine.pb.h"
#include "proto/material.pb.h"

namespace intaglio {

/// The focus of a machine's lens in a glass, and what its largest pulse does there
/// (engrave/optics/pulse_focus.h, focus_heat.h), as far as profile and glass are known.
PulseFocusRecord PulseFocusOf(const MaterialRecord& glass,
                              const OpticalValuesRecord& optics, const LaserHead& laser,
                              const MachineLens& lens);

}  // namespace intaglio
