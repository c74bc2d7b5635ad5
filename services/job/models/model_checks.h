#pragma once

// What is asked about a placed model before anything is made of it: whether its size is
// plausible for the block, and whether it is the right way up. Sentences begin with the
// file's name or the text, and give the option that changes what they ask about.

#include <optional>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mesh/mesh.h"
#include "engrave/mesh/up_axis.h"
#include "services/job/methods/point_maker.h"

namespace intaglio {

/// kOutsideBlock for a size that is refused (plausible_size.h); any other fault of the
/// size is added to `warnings`.
Status CheckSize(const MethodInput& input, const Vec3& size_mm, Warnings& warnings);

/// A mesh that rests on another face than its flat one (base_face.h), that is rotated as
/// it lies in a file that declares another axis up (mesh::UpAxisOfFile), or whose format
/// leaves open which axis that is (mesh::UpConventionOf), while nobody has said so: up is
/// UP_AXIS_DECLARED. A warning where the flat face speaks for the convention, else a
/// note.
void AddOrientationOfMesh(const MethodInput& input, std::optional<mesh::UpAxis> declared,
                          const mesh::TriangleMesh& placed, Warnings& warnings);

/// A drawing, text or image that lies flat because it is rotated as it lies in its file.
void AddOrientationOfSheet(const MethodInput& input, Warnings& warnings);

}  // namespace intaglio
