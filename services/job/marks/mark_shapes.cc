#include "services/job/marks/mark_shapes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/matrix_code/matrix_code.h"
#include "services/job/marks/image_marks.h"
#include "services/job/models/code_model.h"
#include "services/job/models/flat_models.h"

namespace intaglio {
namespace {

// Drawings of CAD programs meet to the last digit of their files.
constexpr double kJoinMm = 0.001;

Error InField(const char* field, Error error) {
  error.message = fmt::format("{}: {}", field, error.message);
  return error;
}

Status KeepDrawingLayers(const MarkDrawing& item, const std::vector<std::string>& names,
                         drawing::FlatDrawing& flat) {
  if (item.layers().empty()) return {};
  std::set<std::string> present;
  for (const drawing::FlatCurve& curve : flat.curves)
    present.insert(names.at(curve.layer));
  for (const std::string& layer : item.layers()) {
    if (present.contains(layer)) continue;
    return Fail(ErrorCode::kNotFound,
                fmt::format("drawing.layers: {} has no curves on a layer \"{}\"; its "
                            "layers are \"{}\"",
                            item.file(), layer, fmt::join(present, "\", \"")),
                layer);
  }
  std::erase_if(flat.curves, [&](const drawing::FlatCurve& curve) {
    return std::ranges::find(item.layers(), names.at(curve.layer)) == item.layers().end();
  });
  return {};
}

/// Points of a drawing are no strokes, and are left out.
void AppendShapes(const drawing::FlatDrawing& flat, MarkShapes& made) {
  for (const drawing::FlatCurve& curve : flat.curves) {
    MarkShape shape{{}, curve.closed && curve.points_mm.size() > 2};
    shape.places_mm.reserve(curve.points_mm.size());
    for (const Vec3& p : curve.points_mm) shape.places_mm.push_back(p.head<2>());
    if (shape.places_mm.size() > 1) made.shapes.push_back(std::move(shape));
  }
}

Result<MarkShapes> DrawingShapes(const MarkDrawing& item, const MarkFile& file,
                                 const ReadLimits& limits, Warnings& warnings) {
  const auto drawing = ReadDrawing(file.name, file.bytes, limits.drawings, warnings);
  if (!drawing)
    return tl::unexpected(InField("drawing.file", WithRemedy(drawing.error(), limits)));
  auto flat = drawing::Flatten(*drawing);
  if (!flat) return tl::unexpected(InField("drawing.file", flat.error()));
  INTAGLIO_TRY(KeepDrawingLayers(item, drawing->names, *flat));
  drawing::JoinOpenCurves(kJoinMm, *flat);
  drawing::RemoveRepeatedContours(kJoinMm, *flat);
  MarkShapes made;
  AppendShapes(*flat, made);
  if (made.shapes.empty()) {
    return Fail(ErrorCode::kMissing,
                fmt::format("drawing.file: {} has no curve to mark; draw one", file.name),
                file.name);
  }
  return made;
}

drawing::TextAlignment AlignmentOfText(TextAlignment alignment) {
  if (alignment == TEXT_ALIGNMENT_CENTRE) return drawing::TextAlignment::kCentre;
  return alignment == TEXT_ALIGNMENT_RIGHT ? drawing::TextAlignment::kRight
                                           : drawing::TextAlignment::kLeft;
}

Result<drawing::TextOutliner> OpenFontsOf(const Text& item,
                                          std::span<const MarkFile> fonts) {
  drawing::TextOptions options;
  options.font = {fonts.front().name, fonts.front().bytes};
  for (const MarkFile& font : fonts.subspan(1))
    options.fallbacks.push_back({font.name, font.bytes});
  options.cap_height_mm = item.height_mm();
  options.line_spacing_ratio = item.line_ratio();
  options.alignment = AlignmentOfText(item.alignment());
  return drawing::TextOutliner::Open(std::move(options));
}

Result<MarkShapes> TextShapes(const Text& item, std::span<const MarkFile> files,
                              OpenFonts& fonts) {
  if (!fonts) {
    auto opened = OpenFontsOf(item, files);
    if (!opened) return tl::unexpected(InField("text.text", opened.error()));
    fonts = *std::move(opened);
  }
  const auto outline = fonts->Outline(item.text());
  if (!outline) return tl::unexpected(InField("text.text", outline.error()));
  const auto flat = drawing::Flatten(*outline);
  if (!flat) return tl::unexpected(InField("text.text", flat.error()));
  MarkShapes made;
  made.rule = mark::InsideRule::kNonZero;
  AppendShapes(*flat, made);
  return made;
}

Result<MarkShapes> CodeShapes(const MarkCode& item) {
  const auto grid = INTAGLIO_TRY(GridOf(item));
  MarkShapes made;
  made.module_mm = item.module_mm();
  for (std::vector<Vec2>& outline : matrix_code::ModuleOutlines(grid)) {
    for (Vec2& p : outline) p *= item.module_mm();
    made.shapes.push_back({std::move(outline), true});
  }
  return made;
}

}  // namespace

Result<MarkShapes> ShapesOf(const MarkItem& item, std::span<const MarkFile> files,
                            const ReadLimits& limits, const std::optional<DotRows>& rows,
                            OpenFonts& fonts, Warnings& warnings) {
  if (item.has_drawing())
    return DrawingShapes(item.drawing(), files.front(), limits, warnings);
  if (item.has_text()) return TextShapes(item.text(), files, fonts);
  if (item.has_code()) return CodeShapes(item.code());
  return ImageShapes(item, files.front(), limits, rows);
}

}  // namespace intaglio
