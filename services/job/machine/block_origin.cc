#include "services/job/machine/block_origin.h"

#include <Eigen/LU>
#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/machine/scan_head.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/stations.h"

namespace intaglio {
namespace {

/// How far the block goes for 1 mm of each axis of the stage that carries it.
Eigen::Matrix2d BlockPerStage(const MachineSpec& machine) {
  const BlockStage& stage = machine.head_over_block().block_stage();
  return machine::FieldMatrix(stage.has_x_scale_ratio() ? stage.x_scale_ratio() : 1,
                              stage.has_y_scale_ratio() ? stage.y_scale_ratio() : 1,
                              stage.squareness_xy_rad(), stage.rotation_rad());
}

std::string LensNameOf(const MachineSpec& machine, const JobSpec& job) {
  const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm());
  return lens == nullptr ? "" : lens->name();
}

}  // namespace

const TaughtZero* FindZero(const MachineSpec& machine, std::uint32_t channel,
                           const std::string& lens) {
  for (const TaughtZero& zero : machine.taught().zeros()) {
    if (zero.channel() == channel && zero.lens() == lens) return &zero;
  }
  return nullptr;
}

Vec3 BlockOriginOf(const MachineSpec& machine, std::uint32_t channel,
                   const std::string& lens) {
  const TaughtZero* zero = FindZero(machine, channel, lens);
  if (zero != nullptr) return Vec3Of(zero->block_origin_mm());
  return Vec3Of(machine.block_origin_mm()) - FocusOffsetOf(machine, lens, channel);
}

Vec3 BlockOriginOf(const MachineSpec& machine, const JobSpec& job,
                   std::uint32_t channel) {
  Vec3 origin_mm = BlockOriginOf(machine, channel, LensNameOf(machine, job)) +
                   StationPlaceOf(machine, job).offset_mm;
  origin_mm.head<2>() += BlockPlaceOf(job);
  return origin_mm;
}

Vec2 BlockPlaceOf(const JobSpec& job) {
  return {job.block_place().x_mm(), job.block_place().y_mm()};
}

Vec2 BlockStageAt(const MachineSpec& machine, const Vec2& place_mm) {
  return BlockPerStage(machine).inverse() * place_mm;
}

std::optional<Vec2> BlockStageOf(const FrozenJob& job) {
  if (!job.machine().head_over_block().has_block_stage()) return std::nullopt;
  return BlockStageAt(job.machine(), BlockPlaceOf(job.job()));
}

Vec3 BlockOriginOf(const MachineSpec& machine, const JobSpec& job) {
  return BlockOriginsOf(machine, job).front();
}

std::vector<Vec3> BlockOriginsOf(const MachineSpec& machine, const JobSpec& job) {
  std::vector<Vec3> origins_mm;
  for (const std::uint32_t channel : job.laser().channels()) {
    const Vec3 origin_mm = BlockOriginOf(machine, job, channel);
    if (std::find(origins_mm.begin(), origins_mm.end(), origin_mm) == origins_mm.end()) {
      origins_mm.push_back(origin_mm);
    }
  }
  if (origins_mm.empty()) origins_mm.push_back(BlockOriginOf(machine, job, 1));
  return origins_mm;
}

std::uint32_t FirstChannel(ChannelMask mask) {
  for (std::uint32_t channel = 1; channel <= kMaxChannels; ++channel) {
    if ((mask & MaskOfChannel(channel)) != 0) return channel;
  }
  return 1;
}

optics::MachineFromGlass MachineFromGlassOf(const FrozenJob& job) {
  const double ratio = job.optics().stage_per_glass_ratio();
  Require(ratio > 0 && ratio <= 1, "stage_per_glass_ratio must be in 0..1, is {}", ratio);
  return {BlockOriginOf(job.machine(), job.job()), BlockSizeOf(job.job()), ratio};
}

}  // namespace intaglio
