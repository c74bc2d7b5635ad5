#pragma once

// Makes the sources of the point cloud from the models of a job and the bytes of their
// files. The one place that knows which reader, placement and method a model needs.

#include <cstddef>
#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/cloud.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// A file, byte for byte.
using FileBytes = std::vector<std::byte>;

struct JobSources {
  discretize::Sources sources;              ///< one a model
  std::vector<MeshDiagnosisRecord> meshes;  ///< of the models that are meshes
  std::vector<std::string> warnings;        ///< sentences a person can act on
};

/// `job` with its defaults filled in; `files` as FilesOf (model_kind.h) names them, taken
/// and freed one by one. Errors name the model's file. kCancelled when `progress` returns
/// that.
Result<JobSources> MakeSources(const JobSpec& job, std::vector<FileBytes> files,
                               const ReadLimits& limits, const ProgressSink& progress);

/// Offsets of the copies of a model from its own place; of a model without copies, that
/// place alone.
PointList CopyOffsetsOf(const Model& model);

/// Vertex merging, bounds and clip of a job with its defaults filled in.
discretize::CloudOptions CloudOptionsOf(const JobSpec& job);

/// The files of a job that is made here, from this machine's disks.
Result<std::vector<FileBytes>> ReadFilesOf(const JobSpec& job, const ReadLimits& limits);

/// The mesh of a model of that kind, model frame; errors with the way to raise the
/// limits.
Result<mesh::TriangleMesh> ReadMeshOf(const Model& model, const ReadLimits& limits);

/// The largest extents of the placed models, mm: a block has to hold them. `job` with its
/// defaults filled in, and a block of any size.
Result<Vec3> SizeOf(const JobSpec& job, const ReadLimits& limits);

}  // namespace intaglio
