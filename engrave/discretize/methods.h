#pragma once

// Every way from models to points, by name, and the whole way: method, bounds, weld.
// A new method is one header, one source, one test and one line of the registry in
// methods.cc.

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/fill.h"
#include "engrave/discretize/rays.h"
#include "engrave/discretize/sections.h"
#include "engrave/discretize/statistics.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

enum class Method { kSections, kFill, kRays };

struct DiscretizeOptions {
  Method method = Method::kSections;
  SectionOptions sections;
  FillOptions fill;
  RayOptions rays;
  double min_spacing_mm = 0.1;  ///< 0.02..10, over the whole block
  Box3 permitted_mm;            ///< the block minus its margin, glass frame
  bool clip = false;            ///< drop points outside instead of failing
};

struct Discretized {
  PointCloud cloud;  ///< glass frame; from the lowest point up
  std::uint64_t candidate_count = 0;
  std::uint64_t clipped_count = 0;
  std::uint64_t welded_count = 0;  ///< left out by the weld
  std::vector<MethodStatistics> models;
  std::vector<std::string> warnings;  ///< sentences a person can act on
};

/// "sections", "fill" or "rays"; kUnsupported lists them.
Result<Method> MethodFromName(std::string_view name);
const char* NameOf(Method method);

/// Every option outside its range: name, value, allowed range.
std::vector<Error> CheckOptions(const DiscretizeOptions& options);

/// The models, placed in the glass frame, to one cloud. Errors: kInvalidValue (options),
/// kOutsideBlock, kMissing (no points came out), kCancelled, and those of the methods.
Result<Discretized> Discretize(const std::vector<mesh::TriangleMesh>& models,
                               const DiscretizeOptions& options,
                               const ProgressSink& progress);

}  // namespace intaglio::discretize
