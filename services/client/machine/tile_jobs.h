#pragma once

// The jobs of a block that is larger than the usable field of a scan head: one for each
// tile (engrave/sort/way/block_tiles.h). Each is a job of its own, so permission,
// journal, resume and proof of a tile are those of any job. Where the machine has a stage
// that carries the block, each job is of the whole block, with the place at which the
// stage holds it; else of a part of the block that fits under the head with its middle at
// the axis of the lens, and a person moves the block between two jobs.

#include <filesystem>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/sort/way/block_tiles.h"
#include "proto/task.pb.h"

namespace intaglio::client {

/// Width and depth of the part of a block whose middle lies at the axis of the lens with
/// this profile and lens, mm: twice the way from the block's corner. kUnsupported: no
/// scan head over the block; kInvalidValue: the corner is not beside the axis.
Result<Vec2> PartUnderHead(const MachineSpec& machine, const JobSpec& job);

struct BlockTiling {
  int columns = 1, rows = 1;
  std::vector<sort::BlockTile> tiles;
};

/// The fewest tiles whose points are all within the margins of the part and within the
/// usable radius at their depth, with the energy that the job may use there. `job`: that
/// of the part under the head, as high as the block. Points in the frame of the whole
/// block, mm, one or more. kOutsideBlock: the beam is too weak for tiles of any size.
Result<BlockTiling> ChooseTiles(const FrozenJob& job, const PointList& points_mm,
                                double strip_mm);

/// Writes tile-001.xyz and tile-001.textproto of each tile, and tiles.csv: in which order
/// they are made, and where the block is, whose size is `block_mm`. The folder is made.
/// kInvalidValue: a tile that the stage that carries the block does not reach; errors of
/// the disk.
Status WriteTileJobs(const FrozenJob& job, const PointList& points_mm,
                     const BlockTiling& tiling, const Vec3& block_mm,
                     const std::filesystem::path& folder);

}  // namespace intaglio::client
