#pragma once

// The position of a picture. Image frame: mm, x right, y up, z towards the viewer; the
// picture's lower left corner lies at the origin, its upper right at (width, height, 0).
// Layers follow each other along +z.

#include "engrave/core/result.h"
#include "engrave/image/grey_image.h"
#include "engrave/mesh/placement.h"

namespace intaglio::discretize {

/// How large a picture is made ("quantization", Trochimczuk 2008 annex E).
struct PanelSize {
  enum class Rule {
    kGiven,  ///< width and height; a zero follows from the picture's proportions
    kFit,    ///< as large as it can be within width x height, in its proportions
    kPixel,  ///< every pixel is a vertex distance wide and high
  };
  Rule rule = Rule::kGiven;
  double width_mm = 0;   ///< 0..1000
  double height_mm = 0;  ///< 0..1000
};

/// Width and height in the image frame, mm, before the placement. kInvalidValue: values
/// outside their ranges; kMissing: neither width nor height where one is needed.
Result<Vec2> PanelSizeOf(const image::GreyImage& picture, const PanelSize& size,
                         double vertex_distance_mm);

/// The corners of a picture of that size in the image frame: what a placement is computed
/// from (mesh::GlassFromModelOf). `thickness_mm` reaches along z.
PointList PanelCorners(const Vec2& size_mm, double thickness_mm = 0);

/// A placed panel: p_glass = origin + x right + y up + z normal, with unit vectors, so
/// that distances on the panel are distances in the glass.
struct Panel {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitY();
  Vec3 normal = Vec3::UnitZ();
  double width_mm = 0;     ///< after scaling
  double height_mm = 0;    ///< after scaling
  double depth_ratio = 1;  ///< glass mm a mm of the image frame's z

  Vec3 ToGlass(double x_mm, double y_mm, double z_mm) const {
    return origin_mm + x_mm * right + y_mm * up + z_mm * normal;
  }
};

/// Turned, mirrored, moved and scaled (each axis of its own), but not sheared:
/// kInvalidValue.
Result<Panel> PlacePanel(const Vec2& size_mm, const mesh::GlassFromModel& placement);

/// Maximum number of places (squared vertex distances) of a layer: about 600 MB while it
/// is made. Six times the points that a machine engraves (2 million, Trochimczuk 2008 ch.
/// 1).
inline constexpr double kMaxLayerPlaces = 12e6;

/// kTooLarge when a layer would have more places than that.
Status CheckLayerPlaces(double count);

}  // namespace intaglio::discretize
