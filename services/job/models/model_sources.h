#pragma once

// Makes the sources of the point cloud from the models of a job and the bytes of their
// files. The one place that knows which reader, placement and method a model needs.

#include <cstddef>
#include <optional>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/discretize/cloud.h"
#include "engrave/mesh/mesh.h"
#include "engrave/mesh/up_axis.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// A file, byte for byte.
using FileBytes = std::vector<std::byte>;

struct JobSources {
  discretize::Sources sources;              ///< one a model
  std::vector<MeshDiagnosisRecord> meshes;  ///< of the models that are meshes
  std::vector<double> units_mm;  ///< that a unit of its file is long, one a model
  Warnings warnings;
};

/// `job` with its defaults filled in; `files` as FilesOf (model_kind.h) names them, taken
/// and freed one by one. Errors name the model's file. kCancelled when `progress` returns
/// that.
Result<JobSources> MakeSources(const JobSpec& job, std::vector<FileBytes> files,
                               const ReadLimits& limits, const ProgressSink& progress);

/// Offsets of the copies of a model from its own place, in the block as it was turned; of
/// a model without copies, that place alone.
PointList CopyOffsetsOf(const Model& model, const Block& block);

/// Vertex merging, bounds and clip of a job with its defaults filled in.
discretize::CloudOptions CloudOptionsOf(const JobSpec& job);

/// The files of a job that is made here, from this machine's disks.
Result<std::vector<FileBytes>> ReadFilesOf(const JobSpec& job, const ReadLimits& limits);

/// The mesh of a model of that kind in its block, read from this machine's disks; errors
/// with the way to raise the limits. What its reader met and did not obey is added to
/// `warnings`. `job` with its defaults filled in.
Result<mesh::TriangleMesh> PlacedMeshOf(const JobSpec& job, const Model& model,
                                        const ReadLimits& limits, Warnings& warnings);

struct ModelSize {
  Vec3 size_mm = Vec3::Zero();  ///< of the placed model with its copies
  Box3 box_mm;                  ///< the same where it lies in the block, glass frame
  double unit_mm = 1;           ///< that a unit of its file is long
};

/// One a model, read from this machine's disks; nothing is made of meshes. `job` with its
/// defaults filled in, and a block of any size.
Result<std::vector<ModelSize>> SizesOf(const JobSpec& job, const ReadLimits& limits);

/// The up axis that the model's file declares, or its format.
std::optional<mesh::UpAxis> DeclaredUpOf(const Model& model, const FileBytes& file);

}  // namespace intaglio
