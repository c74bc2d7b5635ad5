#include "services/job/models/mesh_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>
#include <variant>

#include "engrave/core/try.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "engrave/mesh/placement.h"
#include "services/job/models/model_checks.h"

namespace intaglio {
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

void Diagnose(const MethodInput& input, const FileBytes& bytes,
              const mesh::TriangleMesh& placed, JobSources& made) {
  const auto found = mesh::Diagnose(placed);
  const std::string& file = input.model.file();
  made.meshes.push_back(RecordOf(file, found));
  const std::string name = std::filesystem::path(file).filename().string();
  for (Warning& warning : mesh::WarningsOf(found, name)) {
    made.warnings.push_back(std::move(warning));
  }
  AddOrientationOfMesh(input, DeclaredUpOf(input.model, bytes), placed, made.warnings);
}

/// Gives `input` the unit of the file, unless the job has one. The reader has multiplied
/// the vertices by it.
mesh::Placement PlacementOfVertices(const mesh::ImportedMesh& imported,
                                    MethodInput& input, Warnings& warnings) {
  const double declared_mm = imported.declared_unit_mm;
  mesh::Placement of_vertices = input.placement;
  if (declared_mm <= 0) return of_vertices;
  if (!input.model.placement().has_unit_mm()) {
    input.placement.unit_mm = declared_mm;
    return of_vertices;
  }
  of_vertices.unit_mm /= declared_mm;
  if (input.placement.unit_mm != declared_mm) {
    warnings.push_back(MakeWarning(
        WarningCode::kChosen,
        fmt::format("{}: its unit is taken as {:g} mm, as the job asks, instead of the "
                    "{:g} mm that the file declares",
                    std::filesystem::path(input.model.file()).filename().string(),
                    input.placement.unit_mm, declared_mm)));
  }
  return of_vertices;
}

}  // namespace

Result<PlacedMesh> PlaceMesh(MethodInput& input, const FileBytes& file,
                             const ReadLimits& limits, Warnings& warnings) {
  const std::string& name = input.model.file();
  const std::string extension = std::filesystem::path(name).extension().string();
  mesh::ImportOptions options = limits.meshes;
  options.objects.assign(input.model.objects().begin(), input.model.objects().end());
  auto imported = INTAGLIO_TRY(limits.read_mesh(file, extension, options, name));
  std::ranges::move(
      WarningsOf(std::filesystem::path(name).filename().string(), imported.findings),
      std::back_inserter(warnings));
  // Vertices of the whole file behind those of its objects decide size and place.
  const std::size_t vertex_count = imported.vertices.size();
  if (!std::exchange(options.objects, {}).empty()) {
    const auto whole = INTAGLIO_TRY(limits.read_mesh(file, extension, options, name));
    imported.vertices.insert(imported.vertices.end(), whole.vertices.begin(),
                             whole.vertices.end());
  }
  PlacedMesh placed;
  placed.mesh = INTAGLIO_TRY(mesh::PlaceInBlock(
      imported, PlacementOfVertices(imported, input, warnings), input.block_size_mm));
  placed.file_mm = placed.mesh.Bounds();
  placed.mesh.vertices.resize(vertex_count);
  return placed;
}

MadePoints MakeMesh(const Method& method, MethodInput& input, const FileBytes& file,
                    const ReadLimits& limits, JobSources& made) {
  auto placed = INTAGLIO_TRY(PlaceMesh(input, file, limits, made.warnings));
  INTAGLIO_TRY(CheckSize(input, placed.file_mm.size_mm(), made.warnings));
  Diagnose(input, file, placed.mesh, made);
  return std::get<MeshMaker>(MakerOf(method).make)(input, std::move(placed.mesh));
}

}  // namespace intaglio
