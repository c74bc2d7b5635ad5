#include "services/job/models/flat_models.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <numbers>
#include <set>
#include <utility>
#include <variant>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/discretize/picture/halftone_panel.h"
#include "engrave/discretize/spacing/fixed_points.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/nci/nci_read.h"
#include "engrave/drawing/svg/svg_read.h"
#include "engrave/image/image_file.h"
#include "engrave/mesh/placement.h"
#include "services/job/convert/model_kind.h"
#include "services/job/convert/placeholders.h"
#include "services/job/models/code_model.h"
#include "services/job/models/model_checks.h"

namespace intaglio {
namespace {

Box3 BoundsOf(const discretize::PlacedDrawing& placed) {
  Box3 box;
  for (const drawing::FlatCurve& curve : placed.flat.curves) {
    for (const Vec3& p : curve.points_mm) box.Extend(p);
  }
  return box;
}

Result<drawing::Drawing> ReadByEnding(const std::string& name, std::string_view file,
                                      const drawing::DrawingLimits& limits,
                                      const std::optional<drawing::FontSource>& font,
                                      std::optional<double> unit_mm) {
  std::string ending = std::filesystem::path(name).extension().string();
  for (char& c : ending) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  drawing::ReadOptions options;
  options.limits = limits;
  options.text_font = font;
  options.unit_mm = unit_mm;
  if (ending == ".dxf") return drawing::ReadDxf(file, options, name);
  if (ending == ".svg") return drawing::ReadSvg(file, options, name);
  if (ending == ".nci") return drawing::ReadNci(file, options, name);
  return drawing::ReadHpgl(file, options, name);
}

/// Curves that enclose an area but for a gap: a browser fills them, too.
void WarnOfUnfilled(const std::string& name, const drawing::FlatDrawing& flat,
                    double spacing_mm, Warnings& warnings) {
  std::uint64_t count = 0;
  double area_mm2 = 0, max_mm2 = 0;
  Vec3 first = Vec3::Zero();
  for (const drawing::FlatCurve& curve : flat.curves) {
    if (curve.closed) continue;
    Vec3 twice = Vec3::Zero();
    const PointList& points = curve.points_mm;
    for (std::size_t k = 2; k < points.size(); ++k)
      twice += (points[k - 1] - points[0]).cross(points[k] - points[0]);
    const double own_mm2 = twice.norm() / 2;
    if (own_mm2 < spacing_mm * spacing_mm) continue;
    if (++count == 1) first = points.front();
    area_mm2 += own_mm2;
    max_mm2 = std::max(max_mm2, own_mm2);
  }
  if (count == 0) return;
  Warning warning = MakeWarning(
      WarningCode::kLeftOut,
      fmt::format(
          "{}: {} of {} {} open and not filled, the first from ({:.4g}, {:.4g}, "
          "{:.4g}) mm in the glass; up to {:.4g} mm2 each and {:.4g} mm2 together "
          "have no points within their outline: close them in the drawing",
          name, count, Counted(flat.curves.size(), "curve"), VerbFor(count, "is", "are"),
          first.x(), first.y(), first.z(), max_mm2, area_mm2));
  warning.weight = WarningWeight::kWarning;
  warnings.push_back(std::move(warning));
}

/// The curves of the model's layers; of a model without layers all.
Status KeepLayers(const Model& model, const std::vector<std::string>& names,
                  drawing::FlatDrawing& flat) {
  if (model.layers().empty()) return {};
  std::set<std::uint32_t> kept;
  std::set<std::string> present;
  for (const drawing::FlatCurve& curve : flat.curves) {
    const std::string& name = names.at(curve.layer);
    present.insert(name);
    if (std::ranges::find(model.layers(), name) != model.layers().end()) {
      kept.insert(curve.layer);
    }
  }
  for (const std::string& layer : model.layers()) {
    if (present.contains(layer)) continue;
    return Fail(ErrorCode::kNotFound,
                fmt::format("layers: the drawing has no curves on a layer \"{}\"; its "
                            "layers are \"{}\"",
                            layer, fmt::join(present, "\", \"")),
                layer);
  }
  std::erase_if(flat.curves, [&](const drawing::FlatCurve& curve) {
    return !kept.contains(curve.layer);
  });
  return {};
}

Result<image::GreyImage> ReadPicture(const Method& method, std::string_view file,
                                     const ReadLimits& limits) {
  image::ImageOptions reading;
  reading.limits = limits.images;
  reading.samples = std::get<PictureMaker>(MakerOf(method).make).samples;
  return image::ParseImage(file, reading);
}

}  // namespace

Result<drawing::Drawing> ReadDrawing(const std::string& name, std::string_view file,
                                     const drawing::DrawingLimits& limits,
                                     Warnings& warnings,
                                     const std::optional<drawing::FontSource>& text_font,
                                     std::optional<double> unit_mm) {
  auto drawing = INTAGLIO_TRY(ReadByEnding(name, file, limits, text_font, unit_mm));
  std::ranges::move(
      WarningsOf(std::filesystem::path(name).filename().string(), drawing.findings),
      std::back_inserter(warnings));
  return drawing;
}

MadePoints MakeDrawing(const Method& method, MethodInput& input, std::string_view file,
                       std::string_view font, const ReadLimits& limits,
                       SizeCheck size_check, Warnings& warnings) {
  const std::string& name = input.model.file();
  std::optional<drawing::FontSource> text_font;
  if (!font.empty()) text_font = {input.model.text().font(), font};
  std::optional<double> unit_mm;
  if (input.model.placement().has_unit_mm()) {
    unit_mm = input.model.placement().unit_mm();
  }
  const auto drawing = INTAGLIO_TRY(
      ReadDrawing(name, file, limits.drawings, warnings, text_font, unit_mm));
  mesh::Placement of_curves = input.placement;
  of_curves.unit_mm = 1;                      // the reader applies it
  input.placement.unit_mm = drawing.unit_mm;  // which messages name
  auto placed =
      INTAGLIO_TRY(discretize::PlaceDrawing(drawing, of_curves, input.block_size_mm));
  INTAGLIO_TRY(KeepLayers(input.model, drawing.names, placed.flat));
  if (size_check == SizeCheck::kDone) {
    INTAGLIO_TRY(CheckSize(input, BoundsOf(placed).size_mm(), warnings));
  }
  if (method.fills != nullptr && method.fills(input.model))
    WarnOfUnfilled(name, placed.flat, input.job.discretization().min_spacing_mm(),
                   warnings);
  return std::get<DrawingMaker>(MakerOf(method).make)(input, placed,
                                                      discretize::CurveFill::kEvenOdd);
}

MadePoints MakeLetters(const Method& method, const MethodInput& input,
                       const drawing::Drawing& outline) {
  const auto placed = INTAGLIO_TRY(
      discretize::PlaceDrawing(outline, input.placement, input.block_size_mm));
  return std::get<DrawingMaker>(MakerOf(method).make)(input, placed,
                                                      discretize::CurveFill::kNonZero);
}

MadePoints MakeCodePoints(const Method& method, const MethodInput& input) {
  MarkCode code = input.model.code();
  code.set_text(NumberedText(code.text(), 1));
  // The mean reach of a row of touching discs is pi / 8 of their diameter.
  const double inset_mm =
      std::min(std::numbers::pi / 8 * input.job.discretization().min_spacing_mm(),
               code.module_mm() / 4);
  const auto outline = INTAGLIO_TRY(OutlineCode(code, inset_mm));
  const auto placed = INTAGLIO_TRY(
      discretize::PlaceDrawing(outline, input.placement, input.block_size_mm));
  return std::get<DrawingMaker>(MakerOf(method).make)(input, placed,
                                                      discretize::CurveFill::kEvenOdd);
}

MadePoints MakePicture(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits,
                       Warnings& warnings) {
  const auto picture = INTAGLIO_TRY(ReadPicture(method, file, limits));
  const auto [nearest_mm, greatest] = std::ranges::minmax_element(picture.samples);
  if (*nearest_mm == *greatest) {
    Warning even = MakeWarning(
        WarningCode::kLeftOut,
        fmt::format("{}: all its pixels have the same grey, with white behind those that "
                    "are transparent, so nothing of a picture is seen in the piece; put "
                    "another ground behind it in a program for images",
                    std::filesystem::path(input.model.file()).filename().string()));
    even.weight = WarningWeight::kWarning;
    warnings.push_back(std::move(even));
  }
  return std::get<PictureMaker>(MakerOf(method).make).make(input, picture);
}

MadePoints ExtentOfPicture(const Method& method, const MethodInput& input,
                           std::string_view file, const ReadLimits& limits) {
  const auto picture = INTAGLIO_TRY(ReadPicture(method, file, limits));
  auto made =
      INTAGLIO_TRY(std::get<PictureMaker>(MakerOf(method).make).make(input, picture));
  if (input.model.placement().fit_case() == Placement::FIT_NOT_SET) return made;
  Box3 box = made->Bounds();
  // Its pixels are square; the fit gives them their size.
  const PointList corners =
      discretize::PanelCorners(Vec2(picture.width, picture.height), 0);
  const auto glass_from_picture =
      INTAGLIO_TRY(mesh::GlassFromModelOf(corners, input.placement, input.block_size_mm));
  for (const Vec3& corner : corners) box.Extend(glass_from_picture.Apply(corner));
  discretize::SpacedCloud ends;
  ends.Add(box.min_mm, 0);
  ends.Add(box.max_mm, 0);
  return discretize::MakeFixedPoints(std::move(ends));
}

}  // namespace intaglio
