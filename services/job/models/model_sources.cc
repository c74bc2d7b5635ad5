#include "services/job/models/model_sources.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/several.h"
#include "engrave/discretize/spacing/fixed_points.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/whole_file.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "engrave/mesh/mesh_import.h"
#include "engrave/mesh/placement.h"
#include "services/job/channels.h"
#include "services/job/methods/method_table.h"
#include "services/job/model_kind.h"
#include "services/job/models/flat_models.h"
#include "services/job/options.h"

namespace intaglio {
namespace {

using Source = std::unique_ptr<discretize::PointSource>;

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

/// The files of the models in their order, each handed out once.
class Files {
 public:
  explicit Files(std::vector<FileBytes> files) : files_(std::move(files)) {}

  FileBytes Take() {
    Require(next_ < files_.size(), "the job has more than {} files", files_.size());
    return std::exchange(files_[next_++], {});
  }

 private:
  std::vector<FileBytes> files_;
  std::size_t next_ = 0;
};

/// Placeholder for the number of a copy in a text.
constexpr std::string_view kNumber = "{n}";

std::string ExtensionOf(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

std::string_view TextOf(const FileBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A PLY without faces is a cloud. Of a damaged header the reader of meshes reports what
/// is wrong.
bool HoldsPointsOnly(const Model& model, const FileBytes& file) {
  const std::string ending = ExtensionOf(model.file());
  if (ending != ".ply" && ending != ".PLY") return false;
  const auto header = io::ParsePlyHeader(TextOf(file));
  return header && std::none_of(header->elements.begin(), header->elements.end(),
                                [](const io::PlyElement& element) {
                                  return io::HoldsFaces(element) && element.count > 0;
                                });
}

class Maker {
 public:
  Maker(const JobSpec& job, std::vector<FileBytes> files, const ReadLimits& limits,
        JobSources& made)
      : job_(job), files_(std::move(files)), limits_(limits), made_(made) {}

  Result<Source> Make(const Model& model) {
    auto source = MakeOne(model);
    if (source) return WithCopies(model, std::move(*source));
    Error error = WithRemedy(source.error(), limits_);
    const std::string name = model.has_text() ? model.text().text() : model.file();
    if (!error.message.starts_with(name)) error.message = name + ": " + error.message;
    return tl::unexpected(std::move(error));
  }

 private:
  Result<Source> MakeOne(const Model& model) {
    const FileBytes file = files_.Take();
    const auto kind = INTAGLIO_TRY(KindOf(model));
    const Method* method = MethodOf(model);
    Require(Suits(model.method_case(), kind),
            "{} has no method that suits it: the job's defaults are not filled in",
            NameOf(kind));
    const Block block = BlockOf(job_, model);
    MethodInput input{
        job_, model, PlacementOf(model.placement(), block), Vec3Of(block.size_mm()), {}};
    if (method != nullptr) {
      INTAGLIO_TRY(ReadImages(*method, input));
    }
    switch (kind) {
      case ModelKind::kMesh:
        return HoldsPointsOnly(model, file) ? OfCloud(input, file)
                                            : OfMesh(*method, input, file);
      case ModelKind::kCloud:
        return OfCloud(input, file);
      case ModelKind::kDrawing:
        return MakeDrawing(*method, input, TextOf(file), limits_, made_.warnings);
      case ModelKind::kImage:
        return MakePicture(*method, input, TextOf(file), limits_);
      case ModelKind::kText:
        return OfText(*method, input, file);
    }
    throw PreconditionError("a model of no kind");
  }

  /// Takes the files that fields of the method name, in the order of FilesOf.
  Status ReadImages(const Method& method, MethodInput& input) {
    const auto& message = MessageOf(method, input.model);
    for (const MethodField& row : method.fields) {
      const auto* field = method.message().FindFieldByName(std::string(row.name));
      if (!row.names_image || !message.GetReflection()->HasField(message, field)) {
        continue;
      }
      const FileBytes file = files_.Take();
      image::ImageOptions reading;
      reading.limits = limits_.images;
      auto image = image::ParseImage(TextOf(file), reading);
      if (!image) {
        const std::string name = message.GetReflection()->GetString(message, field);
        return Fail(image.error().code, name + ": " + image.error().message,
                    image.error().value);
      }
      input.images.emplace(row.name, std::move(*image));
    }
    return {};
  }

  /// Copies of a numbered text are texts of their own.
  static Result<Source> OfText(const Method& method, const MethodInput& input,
                               const FileBytes& font) {
    const std::string& text = input.model.text().text();
    if (text.find(kNumber) == std::string::npos) {
      return MakeText(method, input, text, TextOf(font));
    }
    std::vector<Source> pieces;
    for (const Vec3& offset_mm : CopyOffsetsOf(input.model)) {
      std::string numbered = text;
      for (auto at = numbered.find(kNumber); at != std::string::npos;
           at = numbered.find(kNumber, at)) {
        numbered.replace(at, kNumber.size(), std::to_string(pieces.size() + 1));
      }
      auto piece = MakeText(method, input, numbered, TextOf(font));
      if (!piece) return piece;
      pieces.push_back(discretize::MakeShifted(std::move(*piece), offset_mm));
    }
    return discretize::MakeSeveral(std::move(pieces));
  }

  Result<Source> OfMesh(const Method& method, const MethodInput& input,
                        const FileBytes& file) {
    const std::string& name = input.model.file();
    auto imported =
        INTAGLIO_TRY(limits_.read_mesh(file, ExtensionOf(name), limits_.meshes, name));
    auto placed =
        INTAGLIO_TRY(mesh::PlaceInBlock(imported, input.placement, input.block_size_mm));
    Diagnose(input, placed);
    return std::get<MeshMaker>(method.make)(input, std::move(placed));
  }

  void Diagnose(const MethodInput& input, const mesh::TriangleMesh& placed) {
    const auto found = mesh::Diagnose(placed);
    const std::string& file = input.model.file();
    made_.meshes.push_back(RecordOf(file, found));
    const std::string name = std::filesystem::path(file).filename().string();
    for (std::string& warning : mesh::Warnings(found, name)) {
      made_.warnings.push_back(std::move(warning));
    }
    if (auto warning =
            mesh::SizeWarning(found.bounds_mm.size_mm(), input.block_size_mm, name)) {
      made_.warnings.push_back(std::move(*warning));
    }
  }

  Result<Source> OfCloud(const MethodInput& input, const FileBytes& file) const {
    const auto table = INTAGLIO_TRY(formats::ParsePoints(
        TextOf(file), ExtensionOf(input.model.file()), limits_.points));
    const auto glass_from_model = INTAGLIO_TRY(
        mesh::GlassFromModelOf(table.points_mm, input.placement, input.block_size_mm));
    discretize::SpacedCloud points;
    for (const Vec3& p : table.points_mm) points.Add(glass_from_model.Apply(p), 0);
    return discretize::MakeFixedPoints(std::move(points));
  }

  static Source WithCopies(const Model& model, Source source) {
    const bool numbered = model.text().text().find(kNumber) != std::string::npos;
    if (!model.has_copies() || numbered) return source;
    const std::shared_ptr<const discretize::PointSource> one = std::move(source);
    std::vector<Source> all;
    for (const Vec3& offset_mm : CopyOffsetsOf(model)) {
      all.push_back(discretize::MakeShifted(one, offset_mm));
    }
    return discretize::MakeSeveral(std::move(all));
  }

  const JobSpec& job_;
  Files files_;
  const ReadLimits& limits_;
  JobSources& made_;
};

}  // namespace

Result<JobSources> MakeSources(const JobSpec& job, std::vector<FileBytes> files,
                               const ReadLimits& limits, const ProgressSink& progress) {
  JobSources made;
  Maker maker(job, std::move(files), limits, made);
  for (const Model& model : job.models()) {
    auto source = INTAGLIO_TRY(maker.Make(model));
    made.sources.push_back(std::move(source));
    if (progress && !progress(0, 0)) {
      return Fail(ErrorCode::kCancelled, "the task was cancelled");
    }
  }
  return made;
}

Result<std::vector<FileBytes>> ReadFilesOf(const JobSpec& job, const ReadLimits& limits) {
  std::vector<FileBytes> files;
  for (const std::string& path : FilesOf(job)) {
    const auto text = io::ReadWholeFile(path, limits.max_file_bytes);
    if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
    const auto bytes = std::as_bytes(std::span(*text));
    files.emplace_back(bytes.begin(), bytes.end());
  }
  return files;
}

Result<mesh::TriangleMesh> ReadMeshOf(const Model& model, const ReadLimits& limits) {
  const auto text = io::ReadWholeFile(model.file(), limits.max_file_bytes);
  if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
  auto mesh = limits.read_mesh(std::as_bytes(std::span(*text)), ExtensionOf(model.file()),
                               limits.meshes, model.file());
  if (!mesh) return tl::unexpected(WithRemedy(mesh.error(), limits));
  return mesh;
}

Result<Vec3> SizeOf(const JobSpec& job, const ReadLimits& limits) {
  auto files = INTAGLIO_TRY(ReadFilesOf(job, limits));
  // How many and how near does not matter: the fewest will do.
  const auto made = INTAGLIO_TRY(MakeSources(job, std::move(files), limits, {}));
  Vec3 size_mm = Vec3::Zero();
  for (const auto& source : made.sources) {
    size_mm = size_mm.cwiseMax(source->Bounds().size_mm());
  }
  return size_mm;
}

PointList CopyOffsetsOf(const Model& model) {
  if (!model.has_copies()) return {Vec3::Zero()};
  const Copies& copies = model.copies();
  const Eigen::Vector3i count(static_cast<int>(copies.count_x()),
                              static_cast<int>(copies.count_y()),
                              static_cast<int>(copies.count_z()));
  return discretize::GridOffsets(count, Vec3Of(copies.step_mm()),
                                 model.placement().centre_in_block());
}

discretize::CloudOptions CloudOptionsOf(const JobSpec& job) {
  discretize::CloudOptions options;
  options.thinning.min_spacing_mm = job.discretization().min_spacing_mm();
  options.thinning.height_ratio = job.discretization().height_ratio();
  options.permitted_mm = PermittedBoxOf(job.block());
  std::vector<ChannelMask> masks = ChannelsOfModels(job);
  if (DistinctMasks(masks).size() > 1)
    options.thinning.channels_of_source = std::move(masks);
  for (const Model& model : job.models()) {
    if (job.channel_blocks().empty()) break;
    options.permitted_of_source_mm.push_back(PermittedBoxOf(BlockOf(job, model)));
  }
  options.clip = job.block().clip();
  return options;
}

}  // namespace intaglio
