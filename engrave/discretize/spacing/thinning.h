#pragma once

// Thinning: no two points are too near to each other in the whole block, whatever method
// or model they come from. Frame glass, mm.

#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/discretize/spacing/spaced_cloud.h"

namespace intaglio::discretize {

struct ThinningOptions {
  double min_spacing_mm = 0.1;  ///< > 0, between any two points
  /// The spacing along z by that across, 1..10: a crack is longer along the beam.
  double height_ratio = 1;
  /// By the number of a source; empty: all sources have the same channels.
  std::vector<ChannelMask> channels_of_source = {};
  /// The direction in which the front of the kept points rises, of unit length, no
  /// component negative.
  Vec3 rise = Vec3::UnitZ();
};

/// Removes candidates until none are too near to each other or to the points `taken`.
///
/// Two points are too near when, computed in doubles as written,
///   dx * dx + dy * dy + (dz / height_ratio) * (dz / height_ratio)
///     < min_spacing_mm * min_spacing_mm,
/// or when they have the same source and dx * dx + dy * dy + dz * dz < s * s with s the
/// larger of their own spacings. Points of sources without a common channel lie in
/// different blocks and are never too near. Every removed candidate is too near to a kept
/// or taken point. The points taken are not in the result.
///
/// The result, its order included, depends on the set of the points, not on their
/// sequence: candidates are kept from the lowest up, by their height along the rise, then
/// y, then x, then source, then spacing, then z. Own spacings may differ without
/// restriction. Time is proportional to the number of points as long as the density of
/// candidates, relative to their own spacing, is the same everywhere.
SpacedCloud Thin(const SpacedCloud& candidates, const ThinningOptions& options,
                 const SpacedCloud& taken = {});

}  // namespace intaglio::discretize
