#pragma once

// A picture in relief: a depth map gives a surface z = depth(x, y) over the panel, a
// photo gives the density of the points on it (3.5; today's users supply a photo and a
// depth map). The points are even on the surface, not in its projection: steep places get
// as many points per mm^2 of surface as flat ones.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/picture/halftone_panel.h"
#include "engrave/discretize/picture/halftone_tone.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/image/grey_image.h"
#include "engrave/mesh/placement.h"

namespace intaglio::discretize {

struct ReliefOptions {
  PanelSize size;                   ///< of the depth map; the photo covers the same panel
  double depth_mm = 10;             ///< 0..500, from the map's 0 to its 1, image frame z
  bool white_is_near = true;        ///< near: z = depth_mm; else white lies at z = 0
  double smoothing_mm = 0;          ///< 0..10: the map's means over squares of that side
                                    ///< (against the steps of 8-bit maps)
  double vertex_distance_mm = 0.1;  ///< 0.01..100, minimum distance of points, glass mm
  int layer_count = 1;              ///< 1..10, each with its own points
  double layer_distance_mm = 1;     ///< 0..50 along z, at least vertex_distance_mm
  ToneCurve tone;                   ///< of the photo
  std::uint64_t seed = 1;           ///< the same seed gives the same points
};

/// Every option outside its range: name, value, allowed range.
std::vector<Error> CheckRelief(const ReliefOptions& options);

/// `depth_map` as stored, `photo` in linear light; without a photo all is white. White
/// gets about 0.7 / d^2 points a mm^2 of surface, grey its share of them. Errors as of
/// MakeHalftone; kTooLarge when the surface of all layers has more than kMaxLayerPlaces
/// squared distances.
Result<std::unique_ptr<PointSource>> MakeRelief(
    const image::GreyImage& depth_map, const std::optional<image::GreyImage>& photo,
    const mesh::GlassFromModel& placement, const ReliefOptions& options);

}  // namespace intaglio::discretize
