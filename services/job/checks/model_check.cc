#include "services/job/checks/model_check.h"

#include <filesystem>

#include "engrave/drawing/utf8_characters.h"
#include "engrave/io/lower_case.h"
#include "services/job/convert/model_kind.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

void CheckKindAndMethod(const Model& model, const std::string& path, Findings& findings) {
  const auto kind = KindOf(model);
  if (!kind) {
    if (!model.file().empty()) {
      findings.Wrong(path + ".file", model.file(), "{}", kind.error().message);
    }
    return;
  }
  const Model::MethodCase method = model.method_case();
  if (method == Model::METHOD_NOT_SET || Suits(method, *kind)) return;
  findings.Wrong(path + "." + ChosenField(model, "method")->name(), NameOf(*kind),
                 "cannot be made by this method; remove the method for the default one");
}

void CheckOwnPoints(const Model& model, const std::string& path, Findings& findings) {
  const bool has_other = model.has_text() || model.has_code() || !model.file().empty();
  if (model.points_mm_size() > 0 && has_other) {
    findings.Wrong(path + ".points_mm", model.points_mm_size(),
                   "points are given beside {}; make two models",
                   model.has_text()   ? "a text"
                   : model.has_code() ? "a code"
                                      : "a file");
  }
}

/// Fields that are of models of one kind alone.
void CheckChosenParts(const Model& model, const std::string& path, Findings& findings) {
  const auto kind = KindOf(model);
  if (!kind) return;
  if (model.layers_size() > 0 && *kind != ModelKind::kDrawing) {
    findings.Wrong(path + ".layers", model.layers(0),
                   "is a layer of a drawing, and the model is {}; remove it",
                   NameOf(*kind));
  }
  if (model.objects_size() > 0 && *kind != ModelKind::kMesh) {
    findings.Wrong(path + ".objects", model.objects(0),
                   "is an object of a mesh file, and the model is {}; remove it",
                   NameOf(*kind));
  }
  // A PLY is a mesh or a cloud by its content.
  const bool may_be_cloud =
      *kind == ModelKind::kCloud ||
      io::LowerCaseExtension(std::filesystem::path(model.file()).extension().string()) ==
          "ply";
  if (model.has_min_spacing_mm() && !may_be_cloud) {
    findings.Wrong(
        path + ".min_spacing_mm", model.min_spacing_mm(),
        "is of a cloud of points, and the model is {}; remove it, and give the "
        "distance of its method",
        NameOf(*kind));
  }
}

/// A text without letters beside a file: the font of the texts in a DXF, and no more.
void CheckFontOfDrawing(const Model& model, const std::string& path, Findings& findings) {
  const std::string ending = std::filesystem::path(model.file()).extension().string();
  if (io::LowerCaseExtension(ending) != "dxf") {
    findings.Wrong(path + ".text", model.file(),
                   "has a text without letters, which is the font of the texts in a DXF; "
                   "remove it");
  }
  Text font_alone;
  font_alone.set_font(model.text().font());
  if (model.text().SerializeAsString() != font_alone.SerializeAsString()) {
    findings.Wrong(path + ".text", model.file(),
                   "gives its texts their heights and places: keep text.font alone");
  }
}

void CheckCode(const Model& model, const std::string& path, Findings& findings) {
  if (!model.has_code()) return;
  if (model.has_text() || !model.file().empty()) {
    findings.Wrong(path + ".code", model.code().text(),
                   "is given beside {}; make two models",
                   model.has_text() ? "a text" : "a file");
  }
  if (model.code().text().empty())
    findings.Missing(path + ".code.text", "give the text to encode");
  else if (!drawing::CharactersOf(model.code().text()))
    findings.Wrong(path + ".code.text", "the text", "is not UTF-8; save it as UTF-8");
  if (!MarkCodeKind_IsValid(model.code().kind())) {
    findings.Wrong(path + ".code.kind", static_cast<int>(model.code().kind()),
                   "is none, 0..{}", static_cast<int>(MarkCodeKind_MAX));
  }
}

}  // namespace

void CheckModel(const Model& model, const std::string& path, Findings& findings) {
  CheckOwnPoints(model, path, findings);
  CheckChosenParts(model, path, findings);
  CheckKindAndMethod(model, path, findings);
  CheckCode(model, path, findings);
  if (IsText(model) && !model.file().empty()) {
    findings.Wrong(path + ".file", model.file(),
                   "is given beside a text; make two models");
  }
  if (model.has_text() && !IsText(model)) CheckFontOfDrawing(model, path, findings);
  if (IsText(model) && model.text().text().empty()) {
    findings.Missing(path + ".text.text", "give the text to write");
  }
  if (model.text().shrink_to_fit() &&
      model.placement().fit_case() != Placement::FIT_NOT_SET) {
    findings.Wrong(path + ".text.shrink_to_fit", true,
                   "excludes placement.fit, which decides the size of the text");
  }
  if (model.placement().has_fit_block() && !model.placement().fit_block()) {
    findings.Wrong(path + ".placement.fit_block", false,
                   "is not a fit; use true or remove the field");
  }
}

void CheckModules(const JobSpec& job, Findings& findings) {
  // Fewer points than in three rows are no area to a reader.
  constexpr double kRows = 3, kRoundingMm = 1e-9;
  const double spacing_mm = job.discretization().min_spacing_mm();
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    const Placement& placement = model.placement();
    const bool is_scaled =
        placement.fit_case() != Placement::FIT_NOT_SET ||
        (placement.has_scale_ratio() &&
         (placement.scale_ratio().x() != 1 || placement.scale_ratio().y() != 1));
    if (!model.has_code() || is_scaled) continue;
    if (model.code().module_mm() > kRows * spacing_mm - kRoundingMm) continue;
    findings.Wrong(fmt::format("models[{}].code.module_mm", i), model.code().module_mm(),
                   "is below three times the minimum spacing of {:g} mm, so a reader "
                   "may not read the code: give {:g} or more, or a smaller "
                   "discretization.min_spacing_mm",
                   spacing_mm, kRows * spacing_mm);
  }
}

void CheckOwnSpacing(const JobSpec& job, Findings& findings) {
  const double block_mm = job.discretization().min_spacing_mm();
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    if (!model.has_min_spacing_mm() || model.min_spacing_mm() >= block_mm) continue;
    findings.Wrong(fmt::format("models[{}].min_spacing_mm", i), model.min_spacing_mm(),
                   "is below discretization.min_spacing_mm, {}, which all points of the "
                   "block keep; increase it or remove it",
                   block_mm);
  }
}

}  // namespace intaglio
