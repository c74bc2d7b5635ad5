#pragma once

// Every way from a mesh to points. A new method is one header, one source, one test, one
// member of MeshMethod and one line in methods.cc.

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/mesh/even.h"
#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/mesh/solid.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/discretize/spacing/statistics.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

using MeshMethod =
    std::variant<SectionOptions, FillOptions, RayOptions, EvenOptions, SolidOptions>;

/// The mesh in the glass frame, mm. Errors are those of the methods.
Result<std::unique_ptr<PointSource>> MakeSource(mesh::TriangleMesh mesh,
                                                const MeshMethod& method);

/// What a person should know of one model's points before they are engraved, a sentence
/// each with the remedy.
std::vector<std::string> WarningsOf(const MethodStatistics& statistics,
                                    double min_spacing_mm);

}  // namespace intaglio::discretize
