#include "services/discretizer/discretize_job.h"

#include <filesystem>
#include <utility>

#include "engrave/discretize/methods.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "engrave/mesh/mesh_import.h"
#include "engrave/mesh/placement.h"
#include "proto/options.h"

namespace intaglio::discretizer {
namespace {

MeshDiagnosisRecord RecordOf(const std::string& file, const mesh::MeshDiagnosis& found) {
  MeshDiagnosisRecord record;
  record.set_file(file);
  record.set_triangle_count(found.triangle_count);
  record.set_vertex_count(found.vertex_count);
  record.set_open_edge_count(found.open_edge_count);
  record.set_non_manifold_edge_count(found.non_manifold_edge_count);
  record.set_flipped_edge_count(found.flipped_edge_count);
  record.set_degenerate_triangle_count(found.degenerate_triangle_count);
  const Vec3 size_mm = found.bounds_mm.size_mm();
  record.set_size_x_mm(size_mm.x());
  record.set_size_y_mm(size_mm.y());
  record.set_size_z_mm(size_mm.z());
  return record;
}

/// Imports, places and diagnoses one model; what was found goes to `outcome`.
Result<mesh::TriangleMesh> PlacedModel(const Model& model, const FileBytes& file,
                                       const JobSpec& job, DiscretizeOutcome& outcome) {
  const std::filesystem::path path(model.file());
  const std::string name = path.filename().string();
  auto imported =
      mesh::ImportMeshFromMemory(file, path.extension().string(), {}, model.file());
  if (!imported) return imported;
  const Vec3 block_size_mm = BlockSizeOf(job);
  auto placed = mesh::PlaceInBlock(*imported, PlacementOf(model.placement(), job.block()),
                                   block_size_mm);
  if (!placed) {
    Error error = placed.error();
    error.message = model.file() + ": " + error.message;
    return tl::unexpected(std::move(error));
  }
  const auto found = mesh::Diagnose(*placed);
  *outcome.add_models() = RecordOf(model.file(), found);
  for (const std::string& warning : mesh::Warnings(found, name)) {
    outcome.add_warnings(warning);
  }
  if (const auto warning =
          mesh::SizeWarning(found.bounds_mm.size_mm(), block_size_mm, name)) {
    outcome.add_warnings(*warning);
  }
  return placed;
}

}  // namespace

Result<host::StageResult> DiscretizeJob(const FrozenJob& job,
                                        std::vector<FileBytes> files,
                                        const ProgressSink& progress) {
  const JobSpec& spec = job.job();
  host::StageResult result;
  DiscretizeOutcome& outcome = *result.outcome.mutable_discretize();
  std::vector<mesh::TriangleMesh> models;
  for (int i = 0; i < spec.models_size(); ++i) {
    const FileBytes file = std::exchange(files.at(static_cast<std::size_t>(i)), {});
    auto placed = PlacedModel(spec.models(i), file, spec, outcome);
    if (!placed) return tl::unexpected(placed.error());
    models.push_back(std::move(*placed));
    if (!progress(0, 0)) return Fail(ErrorCode::kCancelled, "the task was cancelled");
  }
  auto points = discretize::Discretize(models, DiscretizeOptionsOf(spec), progress);
  if (!points) return tl::unexpected(points.error());
  outcome.set_candidate_count(points->candidate_count);
  outcome.set_clipped_count(points->clipped_count);
  outcome.set_welded_count(points->welded_count);
  outcome.set_point_count(points->cloud.size());
  for (const std::string& warning : points->warnings) outcome.add_warnings(warning);
  result.cloud = std::move(points->cloud);
  return result;
}

}  // namespace intaglio::discretizer
