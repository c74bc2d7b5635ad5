#pragma once

// A picture as points on one or several plane layers in the glass (3.5 "Raster images",
// Trochimczuk 2008 ch. 6.1 and annex E). Points scatter light, so the brightness of a
// patch grows with its points per mm^2: their number follows the picture's linear light,
// up to the limit of the vertex distance.

#include <cstdint>
#include <memory>

#include "engrave/core/result.h"
#include "engrave/discretize/picture/halftone_panel.h"
#include "engrave/discretize/picture/halftone_tone.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/image/grey_image.h"
#include "engrave/mesh/placement.h"

namespace intaglio::discretize {

enum class HalftoneMethod {
  /// Every place of a square grid whose brightness is at least the threshold; for
  /// pictures of two colours. At most 1 / d^2 points per mm^2 and layer.
  kThreshold,
  /// Floyd and Steinberg 1976 on a square grid, in serpentine order, with noise on the
  /// threshold against patterns (Zhou and Fang 2003). Sharpest. At most 1 / d^2.
  kErrorDiffusion,
  /// Void and cluster (Ulichney 1993) on a triangular grid, and then settled: every point
  /// moves to the middle of the brightness nearest to it, as far as the vertex distance
  /// lets it. Most even. At most 1.155 / d^2.
  kBlueNoise,
};

enum class LayerSharing {
  kOverflow,  ///< the next layer gets what is beyond the density that one layer takes
  kEven,      ///< all layers get the same share: the least crowded
};

struct HalftoneOptions {
  HalftoneMethod method = HalftoneMethod::kBlueNoise;
  PanelSize size;
  /// The minimum distance between points of a layer after scaling: mm in the glass,
  /// 0.01..100. Default: the spacing of a common lens (f = 43 mm needs 0.09).
  double vertex_distance_mm = 0.1;
  ToneCurve tone;
  double threshold = 0.5;        ///< 0..1, on the scale of editors, after the tone curve
  int layer_count = 1;           ///< 1..10
  double layer_distance_mm = 1;  ///< 0..50, mm in the glass; at least vertex_distance_mm
  LayerSharing sharing = LayerSharing::kOverflow;
  /// The approximate number of points: the density is scaled to it (white is clipped at
  /// the limit); kThreshold: the grid is widened. 0: white is the maximum density.
  std::uint64_t target_point_count = 0;
  int settle_count = 6;    ///< kBlueNoise: 0..50 rounds of settling
  std::uint64_t seed = 1;  ///< any; the same seed gives the same points
};

/// Every option outside its range: name, value, allowed range.
std::vector<Error> CheckHalftone(const HalftoneOptions& options);

/// The maximum number of points of a panel of that size with these options.
double MaxHalftonePoints(const Panel& panel, const HalftoneOptions& options);

/// `picture`: linear light. Places of different layers are staggered: none lies above
/// another. Errors: kInvalidValue, kMissing (no size), kTooLarge (kMaxLayerPlaces,
/// candidate_limit.h).
Result<std::unique_ptr<PointSource>> MakeHalftone(const image::GreyImage& picture,
                                                  const mesh::GlassFromModel& placement,
                                                  const HalftoneOptions& options);

}  // namespace intaglio::discretize
