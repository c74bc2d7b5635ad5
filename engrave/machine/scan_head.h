#pragma once

// A scan head over a block: two mirrors move the focus across the field of their lens, a
// slow axis moves it in z. Axes: x, y (mm of the field, commands of the mirrors), z (mm).
// In the glass every ray is refracted (optics/oblique_focus.h), so the commands of a
// place depend on its depth, and z on its place in the field.

#include <memory>

#include "engrave/machine/kinematics.h"

namespace intaglio::machine {

/// The matrix of a field with these scales, whose + of y encloses less than a right angle
/// with + of x by `squareness_rad`, and that is turned counterclockwise by
/// `rotation_rad`.
Eigen::Matrix2d FieldMatrix(double x_ratio, double y_ratio, double squareness_rad,
                            double rotation_rad);

std::shared_ptr<const Kinematics> MakeScanHead(const ScanHeadOptions& options);

}  // namespace intaglio::machine
