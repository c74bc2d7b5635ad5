#include "services/job/model_kind.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

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
    Ending{".png", ModelKind::kImage},   Ending{".jpg", ModelKind::kImage},
    Ending{".jpeg", ModelKind::kImage},  Ending{".bmp", ModelKind::kImage},
    Ending{".xyz", ModelKind::kCloud},   Ending{".cft", ModelKind::kCloud},
    Ending{".scl", ModelKind::kCloud},
};

using Visit = std::function<void(std::string&, const std::string&)>;

void VisitDensity(EvenMethod& even, const std::string& path, const Visit& visit) {
  if (even.has_image()) visit(*even.mutable_image(), path + ".image");
}

void VisitModel(Model& model, const std::string& path, const Visit& visit) {
  if (model.has_text()) {
    visit(*model.mutable_text()->mutable_font(), path + ".text.font");
  } else {
    visit(*model.mutable_file(), path + ".file");
  }
  if (model.has_even()) VisitDensity(*model.mutable_even(), path + ".even", visit);
  if (model.has_relief() && !model.relief().photo().empty()) {
    visit(*model.mutable_relief()->mutable_photo(), path + ".relief.photo");
  }
}

}  // namespace

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
  }
  return "";
}

Result<ModelKind> KindOf(const Model& model) {
  if (model.has_text()) return ModelKind::kText;
  std::string ending = std::filesystem::path(model.file()).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::vector<std::string_view> known;
  for (const Ending& candidate : kEndings) {
    if (candidate.text == ending) return candidate.kind;
    known.push_back(candidate.text);
  }
  return Fail(ErrorCode::kUnsupported,
              fmt::format("is of no kind that is read: {}", fmt::join(known, " ")),
              model.file());
}

bool Suits(Model::MethodCase method, ModelKind kind) {
  switch (method) {
    case Model::kSections:
    case Model::kFill:
    case Model::kRays:
    case Model::kEven:
    case Model::kSolid:
      return kind == ModelKind::kMesh;
    case Model::kCurves:
      return kind == ModelKind::kDrawing || kind == ModelKind::kText;
    case Model::kHalftone:
    case Model::kRelief:
      return kind == ModelKind::kImage;
    case Model::METHOD_NOT_SET:
      break;
  }
  return kind == ModelKind::kCloud;
}

void ForEachFile(JobSpec& job, const Visit& visit) {
  for (int i = 0; i < job.models_size(); ++i) {
    VisitModel(*job.mutable_models(i), fmt::format("models[{}]", i), visit);
  }
  if (job.discretization().has_even()) {
    VisitDensity(*job.mutable_discretization()->mutable_even(), "discretization.even",
                 visit);
  }
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
