#include "services/job/convert/model_kind.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>

#include "engrave/io/lower_case.h"
#include "engrave/mesh/mesh_formats.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

struct Ending {
  std::string_view text;
  ModelKind kind;
};

constexpr std::array kEndings = {
    Ending{".stl", ModelKind::kMesh},    Ending{".obj", ModelKind::kMesh},
    Ending{".ply", ModelKind::kMesh},    Ending{".3mf", ModelKind::kMesh},
    Ending{".glb", ModelKind::kMesh},    Ending{".gltf", ModelKind::kMesh},
    Ending{".dae", ModelKind::kMesh},    Ending{".3ds", ModelKind::kMesh},
    Ending{".dxf", ModelKind::kDrawing}, Ending{".svg", ModelKind::kDrawing},
    Ending{".plt", ModelKind::kDrawing}, Ending{".hpgl", ModelKind::kDrawing},
    Ending{".nci", ModelKind::kDrawing}, Ending{".png", ModelKind::kImage},
    Ending{".jpg", ModelKind::kImage},   Ending{".jpeg", ModelKind::kImage},
    Ending{".bmp", ModelKind::kImage},   Ending{".pcx", ModelKind::kImage},
    Ending{".tif", ModelKind::kImage},   Ending{".tiff", ModelKind::kImage},
    Ending{".xyz", ModelKind::kCloud},   Ending{".cft", ModelKind::kCloud},
    Ending{".scl", ModelKind::kCloud},
};

using Visit = std::function<void(std::string&, const std::string&)>;

/// The files that fields of the holder's method name.
void VisitMethod(google::protobuf::Message& holder, const std::string& path,
                 const Visit& visit) {
  const Method* method = MethodOf(holder);
  if (method == nullptr) return;
  google::protobuf::Message& message = MutableMessageOf(*method, holder);
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  for (const auto* field : FieldsOf(method->message())) {
    if (!RuleOf(*field).names_image() || !reflection.HasField(message, field)) continue;
    std::string file = reflection.GetString(message, field);
    visit(file, fmt::format("{}{}.{}", path, method->name(), field->name()));
    reflection.SetString(&message, field, std::move(file));
  }
}

void VisitFonts(Text& text, const std::string& path, const Visit& visit) {
  visit(*text.mutable_font(), path + ".font");
  for (int i = 0; i < text.fallback_fonts_size(); ++i) {
    visit(*text.mutable_fallback_fonts(i), fmt::format("{}.fallback_fonts[{}]", path, i));
  }
}

void VisitModel(Model& model, const std::string& path, const Visit& visit) {
  if (IsText(model)) {
    VisitFonts(*model.mutable_text(), path + ".text", visit);
  } else if (HasFile(model)) {
    visit(*model.mutable_file(), path + ".file");
    if (!model.text().font().empty())
      visit(*model.mutable_text()->mutable_font(), path + ".text.font");
  }
  VisitMethod(model, path + ".", visit);
}

void VisitMarkItem(MarkItem& item, const std::string& path, const Visit& visit) {
  if (item.has_drawing()) {
    visit(*item.mutable_drawing()->mutable_file(), path + ".drawing.file");
  } else if (item.has_text()) {
    VisitFonts(*item.mutable_text(), path + ".text", visit);
  } else if (item.has_image()) {
    visit(*item.mutable_image()->mutable_file(), path + ".image.file");
  }
}

}  // namespace

bool IsText(const Model& model) {
  return model.has_text() && (model.file().empty() || !model.text().text().empty());
}

bool HasFile(const Model& model) {
  if (IsText(model)) return false;
  return !model.file().empty() || (!model.has_code() && model.points_mm_size() == 0);
}

const char* NameOf(ModelKind kind) {
  switch (kind) {
    case ModelKind::kMesh:
      return "a mesh";
    case ModelKind::kDrawing:
      return "a drawing";
    case ModelKind::kText:
      return "a text";
    case ModelKind::kImage:
      return "an image";
    case ModelKind::kCloud:
      return "a cloud of points";
    case ModelKind::kCode:
      return "a code";
  }
  return "";
}

Result<ModelKind> KindOfFile(const std::string& file) {
  const std::string ending =
      io::LowerCase(std::filesystem::path(file).extension().string());
  std::vector<std::string_view> known;
  for (const Ending& candidate : kEndings) {
    if (candidate.text == ending) return candidate.kind;
    known.push_back(candidate.text);
  }
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("has an unknown extension; known are: {}", fmt::join(known, " ")),
      file);
}

Result<ModelKind> KindOf(const Model& model) {
  if (IsText(model)) return ModelKind::kText;
  if (model.file().empty() && model.has_code()) return ModelKind::kCode;
  if (model.file().empty() && model.points_mm_size() > 0) return ModelKind::kCloud;
  return KindOfFile(model.file());
}

bool MayDeclareUnit(const Model& model) {
  const auto kind = KindOf(model);
  if (!kind) return false;
  const std::string extension = std::filesystem::path(model.file()).extension().string();
  return *kind == ModelKind::kDrawing ||
         (*kind == ModelKind::kMesh && mesh::MayDeclareUnit(extension));
}

bool Suits(Model::MethodCase method, ModelKind kind) {
  if (method == Model::METHOD_NOT_SET) return kind == ModelKind::kCloud;
  return std::any_of(Methods().begin(), Methods().end(), [&](const Method& row) {
    return row.number == method && row.Suits(kind);
  });
}

void ForEachFile(JobSpec& job, const Visit& visit) {
  for (int i = 0; i < job.models_size(); ++i) {
    VisitModel(*job.mutable_models(i), fmt::format("models[{}]", i), visit);
  }
  if (job.has_discretization()) {
    VisitMethod(*job.mutable_discretization(), "discretization.", visit);
  }
  for (int i = 0; i < job.course().files_size(); ++i) {
    visit(*job.mutable_course()->mutable_files(i), fmt::format("course.files[{}]", i));
  }
  for (int i = 0; i < job.marks().items_size(); ++i) {
    VisitMarkItem(*job.mutable_marks()->mutable_items(i),
                  fmt::format("marks.items[{}]", i), visit);
  }
  if (!job.marks().table().empty())
    visit(*job.mutable_marks()->mutable_table(), "marks.table");
}

std::vector<std::string> FilesOf(const JobSpec& job) {
  std::vector<std::string> files;
  for (Model model : job.models()) {
    VisitModel(model, "",
               [&](std::string& file, const std::string&) { files.push_back(file); });
  }
  return files;
}

}  // namespace intaglio
