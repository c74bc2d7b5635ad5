#pragma once

// Whether a model rests on its base. Figures, busts and vases have a flat base; a
// model whose flat base is at its top was placed upside down, and one whose base faces
// the viewer lies on its back: files with y up that were taken for z up, as most OBJ
// files are. Tables and cut stones are flat at the top as well, so this is a question to
// a person and not a fault.

#include <optional>

#include "engrave/mesh/mesh.h"
#include "engrave/mesh/up_axis.h"

namespace intaglio::mesh {

/// For a placed mesh (glass frame): the direction that would be up if the model rested on
/// its only flat face, when that is another one than z: kMinusZ (it is upside down) or
/// kY (it lies on its back). Nothing when the bottom is flat, when no or both of these
/// faces are flat, or when the opposite face is flat as well (a box, a plate).
///
/// A face of the bounding box is flat when triangles within 0.2 % of the model's extent
/// from it, whose normals are within 2 degrees of it, cover 30 % of it; it is not flat
/// when they cover less than 2 %. Where no face is: the rough base of a scanned figure,
/// often with holes; within 2 % and 18 degrees, 10 % and 5 %. A sphere has 6 % at every
/// face.
std::optional<UpAxis> UpOfBaseFace(const TriangleMesh& placed);

/// Whether the bottom of a placed mesh is its only flat face, by the same bounds: the
/// model stands on its base.
bool RestsOnBase(const TriangleMesh& placed);

}  // namespace intaglio::mesh
