#pragma once

// In which order the points of a cloud are engraved.
//
// A point must be made before any point above it in the converging beam, because a crack
// above scatters the pulse (Trochimczuk 2008 ch. 1 and 6.7); shadow.h counts where an
// order breaks that. Deterministic: the same points and options give the same order.

#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"

namespace intaglio::sort {

/// Indices into a cloud, in the order of engraving.
using Order = std::vector<std::uint32_t>;

enum class Method {
  kKdz,     ///< greedy in 3D: kdz.h
  kLayers,  ///< a layer at a time: layers.h
};

struct KdzOptions {
  /// K, the weight of a step in z against one in x or y, 0..100. Not less than the
  /// tangent of the beam's cone in the glass, or points are fired through earlier cracks.
  /// 0.6-1.2 moves least, hence the default; DefaultUpRatio (kdz.h) regards the lens as
  /// well.
  double up_ratio = 0.6;
};

struct LayersOptions {
  /// 0.01..100 mm, not less than the distance of the cloud's layers. Default: the usual
  /// distance of sections.
  double layer_thickness_mm = 0.1;
};

struct OrderOptions {
  Method method = Method::kKdz;
  KdzOptions kdz;
  LayersOptions layers;
};

/// "kdz", "layers".
const char* MethodName(Method method);
Result<Method> MethodFromName(std::string_view name);

/// Whether the options of the chosen method are in their ranges; the sentence names them.
Status CheckOrderOptions(const OrderOptions& options);

/// points_mm: glass frame, mm, finite. Every index occurs once. Fails on wrong options,
/// on points that are not finite or too many for the index, and with kCancelled.
Result<Order> MakeOrder(const PointList& points_mm, const OrderOptions& options,
                        const ProgressSink& progress = {});

}  // namespace intaglio::sort
