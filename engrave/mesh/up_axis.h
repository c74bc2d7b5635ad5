#pragma once

// Which axis of a file points up. The block has z up and is seen from the front, from
// -y: a model is turned so that its up axis becomes z and its front faces the viewer.
//
// By their standards: glTF has y up and its front at +z (glTF 2.0, section 3.4). COLLADA
// names the axis in its asset (up_axis, default Y_UP; COLLADA 1.4.1, "up_axis"). STL,
// OBJ, PLY, 3DS and 3MF define none (3MF draws z up); most programs write STL with z up.

#include <string_view>

#include "engrave/core/geometry.h"

namespace intaglio::mesh {

enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

/// "z", "-y", ...
std::string_view NameOf(UpAxis up);

/// The unit vector, model frame.
Vec3 DirectionOf(UpAxis up);

/// The axis nearest to a direction, which is not zero.
UpAxis NearestUpAxis(const Vec3& direction);

/// A turn, exact, after which the axis is z: of y (x, y, z) -> (x, -z, y), so that the
/// front of a glTF and the face of a drawing point to -y; of x first as COLLADA turns
/// X_UP into Y_UP, (x, y, z) -> (-y, x, z). Of a negative axis the same turn after half a
/// turn about the model's x (y and z) or z (x).
Mat3 UprightFrom(UpAxis up);

}  // namespace intaglio::mesh
