#pragma once

// Where the block's corner, the origin of the glass frame, lies in the machine frame: by
// what was taught for the lens and the channel, else by block_origin_mm of the profile
// and where the focus of this lens and channel is (focus_offset.h); where a stage under a
// scan head carries the block, moved to the job's block_place. Machine frame, mm;
// with all axes at zero the beam is at zero. Jobs have every default filled in.

#include <cstdint>
#include <optional>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/optics/machine_frame.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// What was taught; nullptr: nothing for this channel and lens.
const TaughtZero* FindZero(const MachineSpec& machine, std::uint32_t channel,
                           const std::string& lens);

Vec3 BlockOriginOf(const MachineSpec& machine, std::uint32_t channel,
                   const std::string& lens);
/// With the job's lens, at the job's station and block_place.
Vec3 BlockOriginOf(const MachineSpec& machine, const JobSpec& job, std::uint32_t channel);
/// In the first of the job's channels: what estimates are made with.
Vec3 BlockOriginOf(const MachineSpec& machine, const JobSpec& job);
/// Each that the job's channels have, once.
std::vector<Vec3> BlockOriginsOf(const MachineSpec& machine, const JobSpec& job);

/// How far the stage under a scan head has moved the block for a job, machine frame, mm;
/// 0 without block_place. It is in what BlockOriginOf returns for a job.
Vec2 BlockPlaceOf(const JobSpec& job);
/// Where that stage is with the block at a place of the machine frame; mm, by its axes.
/// The machine has such a stage.
Vec2 BlockStageAt(const MachineSpec& machine, const Vec2& place_mm);
/// Where that stage has to be for a job; none: the machine has no such stage.
std::optional<Vec2> BlockStageOf(const FrozenJob& job);

/// The lowest channel of a mask, 1..4; 1 of an empty one.
std::uint32_t FirstChannel(ChannelMask mask);

/// Glass frame to machine frame, focus depth included; the axes: machine_axes.h.
optics::MachineFromGlass MachineFromGlassOf(const FrozenJob& job);

}  // namespace intaglio
