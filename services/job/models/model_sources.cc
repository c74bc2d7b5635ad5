#include "services/job/models/model_sources.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
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
#include "engrave/mesh/files/declared_axis.h"
#include "engrave/mesh/placement.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"
#include "services/job/methods/method_table.h"
#include "services/job/methods/point_maker.h"
#include "services/job/models/flat_models.h"
#include "services/job/models/mesh_models.h"
#include "services/job/models/model_checks.h"
#include "services/job/models/model_file.h"
#include "services/job/models/text_model.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

using Source = std::unique_ptr<discretize::PointSource>;

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

std::string ExtensionOf(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

std::string_view TextOf(const FileBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// "vertex, edge".
std::string ElementsOf(const io::PlyHeader& header) {
  std::vector<std::string> names;
  for (const io::PlyElement& element : header.elements) names.push_back(element.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// A PLY without faces is a cloud, and what it was taken for becomes a note. Of a damaged
/// header the reader of meshes reports what is wrong. kUnsupported: lists of numbers that
/// may be faces and are not understood.
Result<bool> HoldsPointsOnly(const Model& model, const FileBytes& file,
                             Warnings& warnings) {
  const std::string ending = ExtensionOf(model.file());
  if (ending != ".ply" && ending != ".PLY") return false;
  const auto header = io::ParsePlyHeader(TextOf(file));
  if (!header) return false;
  const auto note = [&](const std::string& what) {
    const std::string name = std::filesystem::path(model.file()).filename().string();
    warnings.push_back(MakeWarning(WarningCode::kChosen, name + ": " + what));
  };
  for (const io::PlyElement& element : header->elements) {
    if (!io::HoldsFaces(element) || element.count == 0) continue;
    note(fmt::format("read as a mesh, because its header has {} of element {}",
                     element.count, element.name));
    return false;
  }
  for (const io::PlyElement& element : header->elements) {
    if (!io::HoldsLists(element) || element.count == 0) continue;
    return Fail(ErrorCode::kUnsupported,
                fmt::format("its element {} has lists, which may be faces and are not "
                            "understood; export the faces as element face with a list "
                            "vertex_indices, or remove the element for a cloud of points",
                            element.name),
                element.name);
  }
  note(
      fmt::format("read as a cloud of points, because its header has no faces (element "
                  "face, tristrips or range_grid), but {}",
                  ElementsOf(*header)));
  return true;
}

enum class Purpose {
  kPoints,  ///< sources of the job's points
  kExtent,  ///< of meshes their bounding boxes alone; sizes are not checked
};

class Maker {
 public:
  Maker(const JobSpec& job, std::vector<FileBytes> files, const ReadLimits& limits,
        Purpose purpose, JobSources& made)
      : job_(job),
        files_(std::move(files)),
        limits_(limits),
        purpose_(purpose),
        made_(made) {}

  Result<Source> Make(const Model& model) {
    auto source = MakeOne(model);
    if (source) return WithCopies(model, std::move(*source));
    Error error = WithRemedy(source.error(), limits_);
    const std::string name = IsText(model)     ? model.text().text()
                             : !HasFile(model) ? model.code().text()
                                               : model.file();
    if (error.message.find(name) == std::string::npos)
      error.message = name + ": " + error.message;
    return tl::unexpected(std::move(error));
  }

 private:
  Result<Source> MakeOne(const Model& model) {
    const bool needs_file = HasFile(model) || IsText(model);
    const FileBytes file = needs_file ? files_.Take() : FileBytes();
    const auto kind = INTAGLIO_TRY(KindOf(model));
    const bool has_font = !IsText(model) && !model.text().font().empty();
    const FileBytes font = has_font ? files_.Take() : FileBytes();
    const Method* method = MethodOf(model);
    Require(Suits(model.method_case(), kind),
            "{} has no method that suits it: the job's defaults are not filled in",
            NameOf(kind));
    const Block block = BlockOf(job_, model);
    MethodInput input{job_,
                      model,
                      PlacementOf(model.placement(), block, DeclaredUpOf(model, file)),
                      Vec3Of(block.size_mm()),
                      {}};
    if (method != nullptr) {
      INTAGLIO_TRY(ReadImages(*method, input));
    }
    auto source = INTAGLIO_TRY(MakeOfKind(kind, method, input, file, font));
    made_.units_mm.push_back(input.placement.unit_mm);
    return source;
  }

  Result<Source> MakeOfKind(ModelKind kind, const Method* method, MethodInput& input,
                            const FileBytes& file, const FileBytes& font) {
    switch (kind) {
      case ModelKind::kMesh:
        return INTAGLIO_TRY(HoldsPointsOnly(input.model, file, made_.warnings))
                   ? OfCloud(input, file)
                   : OfMesh(*method, input, file);
      case ModelKind::kCloud:
        return OfCloud(input, file);
      case ModelKind::kDrawing:
        AddOrientationOfSheet(input, made_.warnings);
        return MakeDrawing(
            *method, input, TextOf(file), TextOf(font), limits_,
            purpose_ == Purpose::kPoints ? SizeCheck::kDone : SizeCheck::kLeftOut,
            made_.warnings);
      case ModelKind::kImage:
        AddOrientationOfSheet(input, made_.warnings);
        return purpose_ == Purpose::kPoints
                   ? MakePicture(*method, input, TextOf(file), limits_, made_.warnings)
                   : ExtentOfPicture(*method, input, TextOf(file), limits_);
      case ModelKind::kText:
        AddOrientationOfSheet(input, made_.warnings);
        return OfText(*method, input, file);
      case ModelKind::kCode:
        AddOrientationOfSheet(input, made_.warnings);
        return MakeCodePoints(*method, input);
    }
    throw PreconditionError("a model of no kind");
  }

  /// Takes the files that fields of the method name, in the order of FilesOf.
  Status ReadImages(const Method& method, MethodInput& input) {
    const auto& message = MessageOf(method, input.model);
    for (const auto* field : FieldsOf(method.message())) {
      if (!RuleOf(*field).names_image() ||
          !message.GetReflection()->HasField(message, field)) {
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
      input.images.emplace(field->name(), std::move(*image));
    }
    return {};
  }

  /// Copies of a numbered text are texts of their own.
  Result<Source> OfText(const Method& method, const MethodInput& input,
                        const FileBytes& font) {
    const Text& text = input.model.text();
    std::vector<FileBytes> files;
    for (int i = 0; i < text.fallback_fonts_size(); ++i) files.push_back(files_.Take());
    std::vector<drawing::FontSource> fonts = {{text.font(), TextOf(font)}};
    for (int i = 0; i < text.fallback_fonts_size(); ++i) {
      fonts.push_back(
          {text.fallback_fonts(i), TextOf(files[static_cast<std::size_t>(i)])});
    }
    const auto outlined = INTAGLIO_TRY(OutlineText(job_, input.model, fonts));
    made_.warnings.insert(made_.warnings.end(), outlined.warnings.begin(),
                          outlined.warnings.end());
    if (!IsNumbered(text)) return MakeLetters(method, input, outlined.outlines.front());
    const PointList offsets_mm = CopyOffsetsOf(input.model, job_.block());
    std::vector<Source> pieces;
    for (const drawing::Drawing& outline : outlined.outlines) {
      auto piece = INTAGLIO_TRY(MakeLetters(method, input, outline));
      const Vec3& offset_mm = offsets_mm[pieces.size()];
      pieces.push_back(discretize::MakeShifted(std::move(piece), offset_mm));
    }
    return discretize::MakeSeveral(std::move(pieces));
  }

  Result<Source> OfMesh(const Method& method, MethodInput& input, const FileBytes& file) {
    if (input.model.has_min_spacing_mm()) {
      return Fail(
          ErrorCode::kInvalidValue,
          "min_spacing_mm is of a cloud of points, and the file is a mesh; remove "
          "it, and give the distance of its method");
    }
    if (purpose_ == Purpose::kPoints)
      return MakeMesh(method, input, file, limits_, made_);
    const auto placed = INTAGLIO_TRY(PlaceMesh(input, file, limits_, made_.warnings));
    discretize::SpacedCloud corners;
    corners.Add(placed.file_mm.min_mm, 0);
    corners.Add(placed.file_mm.max_mm, 0);
    return discretize::MakeFixedPoints(std::move(corners));
  }

  Result<Source> OfCloud(const MethodInput& input, const FileBytes& file) const {
    PointList points_mm;
    if (!HasFile(input.model)) {
      for (const Vector3& p : input.model.points_mm()) points_mm.push_back(Vec3Of(p));
    } else {
      auto table = INTAGLIO_TRY(formats::ParsePoints(
          TextOf(file), ExtensionOf(input.model.file()), limits_.points));
      points_mm = std::move(table.points_mm);
    }
    const auto glass_from_model = INTAGLIO_TRY(
        mesh::GlassFromModelOf(points_mm, input.placement, input.block_size_mm));
    // Not above it by rounding: points exactly as far apart are kept.
    const float own_spacing_mm =
        std::nextafterf(static_cast<float>(input.model.min_spacing_mm()), 0);
    discretize::SpacedCloud points;
    for (const Vec3& p : points_mm)
      points.Add(glass_from_model.Apply(p), 0, own_spacing_mm);
    return discretize::MakeFixedPoints(std::move(points));
  }

  Source WithCopies(const Model& model, Source source) const {
    if (!model.has_copies() || IsNumbered(model.text())) return source;
    const std::shared_ptr<const discretize::PointSource> one = std::move(source);
    std::vector<Source> all;
    for (const Vec3& offset_mm : CopyOffsetsOf(model, job_.block())) {
      all.push_back(discretize::MakeShifted(one, offset_mm));
    }
    return discretize::MakeSeveral(std::move(all));
  }

  const JobSpec& job_;
  Files files_;
  const ReadLimits& limits_;
  Purpose purpose_;
  JobSources& made_;
};

Result<JobSources> MakeFor(Purpose purpose, const JobSpec& job,
                           std::vector<FileBytes> files, const ReadLimits& limits,
                           const ProgressSink& progress) {
  JobSources made;
  Maker maker(job, std::move(files), limits, purpose, made);
  for (const Model& model : job.models()) {
    auto source = INTAGLIO_TRY(maker.Make(model));
    made.sources.push_back(std::move(source));
    if (progress && !progress(0, 0)) {
      return Fail(ErrorCode::kCancelled, "the task was cancelled");
    }
  }
  return made;
}

}  // namespace

Result<JobSources> MakeSources(const JobSpec& job, std::vector<FileBytes> files,
                               const ReadLimits& limits, const ProgressSink& progress) {
  return MakeFor(Purpose::kPoints, job, std::move(files), limits, progress);
}

Result<std::vector<FileBytes>> ReadFilesOf(const JobSpec& job, const ReadLimits& limits) {
  std::vector<FileBytes> files;
  for (const std::string& path : FilesOf(job)) {
    const auto text = ReadModelFile(path, limits.max_file_bytes);
    if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
    const auto bytes = std::as_bytes(std::span(*text));
    files.emplace_back(bytes.begin(), bytes.end());
  }
  return files;
}

Result<mesh::TriangleMesh> PlacedMeshOf(const JobSpec& job, const Model& model,
                                        const ReadLimits& limits, Warnings& warnings) {
  const auto text = ReadModelFile(model.file(), limits.max_file_bytes);
  if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
  const auto bytes = std::as_bytes(std::span(*text));
  const FileBytes file(bytes.begin(), bytes.end());
  const Block block = BlockOf(job, model);
  MethodInput input{job,
                    model,
                    PlacementOf(model.placement(), block, DeclaredUpOf(model, file)),
                    Vec3Of(block.size_mm()),
                    {}};
  auto placed = PlaceMesh(input, file, limits, warnings);
  if (!placed) return tl::unexpected(WithRemedy(placed.error(), limits));
  return std::move(placed->mesh);
}

Result<std::vector<ModelSize>> SizesOf(const JobSpec& job, const ReadLimits& limits) {
  auto files = INTAGLIO_TRY(ReadFilesOf(job, limits));
  const auto made =
      INTAGLIO_TRY(MakeFor(Purpose::kExtent, job, std::move(files), limits, {}));
  std::vector<ModelSize> sizes;
  for (std::size_t i = 0; i < made.sources.size(); ++i) {
    const Box3 box_mm = made.sources[i]->Bounds();
    sizes.push_back({box_mm.size_mm(), box_mm, made.units_mm.at(i)});
  }
  return sizes;
}

std::optional<mesh::UpAxis> DeclaredUpOf(const Model& model, const FileBytes& file) {
  if (IsText(model)) return std::nullopt;
  return mesh::UpAxisOfFile(ExtensionOf(model.file()), TextOf(file));
}

PointList CopyOffsetsOf(const Model& model, const Block& block) {
  if (!model.has_copies()) return {Vec3::Zero()};
  const Copies& copies = model.copies();
  const Eigen::Vector3i count(static_cast<int>(copies.count_x()),
                              static_cast<int>(copies.count_y()),
                              static_cast<int>(copies.count_z()));
  PointList offsets_mm = discretize::GridOffsets(count, Vec3Of(copies.step_mm()),
                                                 model.placement().centre_in_block());
  const Mat3 turn = mesh::QuarterTurnsAboutZ(static_cast<int>(block.quarter_turns()));
  for (Vec3& offset_mm : offsets_mm) offset_mm = turn * offset_mm;
  return offsets_mm;
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
