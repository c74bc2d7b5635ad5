#pragma once

// The draft of a preview: the same pieces at their places with fewer points, for people
// who wait for the picture of a large job. Its points are made as those of the job are,
// with every spacing a multiple of the job's. How many the job will have follows from two
// drafts: their number is a power of the spacing, with the exponent 2 on a surface and 3
// in a solid.

#include <cstdint>
#include <optional>

#include "proto/task.pb.h"
#include "services/client/preview/preview.h"

namespace intaglio::client {

/// A preview of more points than this takes longer than two seconds, and gets a draft.
inline constexpr double kPointsWithoutDraft = 200'000;
/// A draft goes over the triangles three times: of larger files that takes as long as the
/// preview.
inline constexpr std::uintmax_t kMaxDraftBytes = 64 << 20;

/// Only the names, the sizes, the pictures and the estimated number of points are in it;
/// its verdict is kDraft. nullopt: the job needs none, is not of meshes alone, has
/// files beyond kMaxDraftBytes, or an error, which its preview reports.
std::optional<Preview> MakeDraft(const FrozenJob& job, const PreviewOptions& options);

/// The job with all its distances between points `factor` times as long, as far as their
/// ranges allow.
JobSpec WithSpacings(JobSpec job, double factor);

}  // namespace intaglio::client
