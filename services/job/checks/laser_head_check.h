#pragma once

// Whether the fields of a laser in a machine profile agree with each other.

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Rates, energies, pump, heights of the photosensors, signals; each error begins with
/// its field.
void CheckLaserHead(const LaserHead& laser, std::vector<Error>& errors);

}  // namespace intaglio
