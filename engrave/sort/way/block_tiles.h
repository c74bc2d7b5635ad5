#pragma once

// A block that is larger than the usable field of a scan head, in tiles: a stage moves
// the block, and the axis of the lens stands above the middle of one tile after the
// other.
//
// The tiles are equal rectangles that divide the extent of the points. They are made
// column by column, up in one and down in the next, so each move goes to a neighbour and
// there is one move less than there are tiles. All depths of a tile are made at one place
// of the stage, so the points of a tile must not be fired through cracks of an earlier
// one (beam_cone.h). Which tile makes a point is decided from the top down:
//   1. the tile whose rectangle has the point. Within `strip_mm` of a seam it is either
//   of
//      both neighbours, the nearer one the more often; what a place has had too much of
//      one tile is made up for by its next points (error diffusion, so blue noise);
//   2. when a crack of an earlier tile lies in the beam that comes to the point from the
//      lens above its tile: that earlier tile, until there is none.
// So a seam is upright where beams lean into their own tile, and as oblique as the cone
// of the beam needs where they do not, e.g. below a telecentric lens; and no point of any
// tile is fired through a crack of an earlier tile, whatever the beams.
//
// Depth bands across all tiles would need as many moves for each band.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

struct BlockTileOptions {
  int columns = 1;  ///< along x, 1..1000
  int rows = 1;     ///< along y, 1..1000
  /// How far from a seam its two tiles are mixed, >= 0; at most a quarter of a tile is
  /// used. Default: some spacings of points, which is more than a stage misses.
  double strip_mm = 0.3;
  /// As of PointConeOf a job. The axis of its lean is not regarded: each tile has its
  /// own.
  BeamCone cone;
};

/// One place of the stage.
struct BlockTile {
  Vec2 axis_mm = Vec2::Zero();  ///< where the axis of the lens is, frame of the points
  std::vector<std::uint32_t> members;  ///< indices of its points, rising
};

/// Every point is in one tile; tiles without points are left out. In the order in which
/// they are to be made. Time: some microseconds a point. Throws PreconditionError for
/// options outside their ranges.
std::vector<BlockTile> DivideIntoTiles(const PointList& points_mm,
                                       const BlockTileOptions& options);

}  // namespace intaglio::sort
