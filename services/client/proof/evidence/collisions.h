#pragma once

// What the head of a virtual machine ran into during a job: collisions.json in its
// folder, beside glass.ply, and only where there was something.

#include <filesystem>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/glass_record.h"
#include "proto/report.pb.h"

namespace intaglio::client {

inline constexpr const char* kCollisionsFile = "collisions.json";

/// One a body and what it met, with the deepest overlap, in the order in which they
/// began.
CollisionRecord CollisionsOf(const std::vector<formats::GlassCollision>& collisions);

/// Writes the file, or removes that of an earlier proof when there are none.
Status WriteCollisions(const std::vector<formats::GlassCollision>& collisions,
                       const std::filesystem::path& folder);

/// Empty without the file. kIo, kUnreadable.
Result<CollisionRecord> ReadCollisions(const std::filesystem::path& folder);

/// "the lens was 19.5 mm inside the block (focus at 25, 25, 37.5 mm in air, from tick
/// 17)".
std::string CollisionText(const CollisionReport& collision);

}  // namespace intaglio::client
