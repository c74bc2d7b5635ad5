#include "services/job/models/flat_models.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <variant>

#include "engrave/core/try.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/svg/svg_read.h"
#include "engrave/image/image_file.h"

namespace intaglio {
namespace {

MadePoints PointsOf(const Method& method, const MethodInput& input,
                    const drawing::Drawing& drawing, discretize::CurveFill inside) {
  const auto placed = INTAGLIO_TRY(
      discretize::PlaceDrawing(drawing, input.placement, input.block_size_mm));
  return std::get<DrawingMaker>(method.make)(input, placed, inside);
}

Result<drawing::Drawing> ReadDrawing(const std::string& name, std::string_view file,
                                     const drawing::DrawingLimits& limits) {
  std::string ending = std::filesystem::path(name).extension().string();
  for (char& c : ending) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  drawing::ReadOptions options;
  options.limits = limits;
  if (ending == ".dxf") return drawing::ReadDxf(file, options, name);
  if (ending == ".svg") return drawing::ReadSvg(file, options, name);
  return drawing::ReadHpgl(file, options, name);
}

drawing::TextAlignment AlignmentOf(TextAlignment alignment) {
  switch (alignment) {
    case TEXT_ALIGNMENT_CENTRE:
      return drawing::TextAlignment::kCentre;
    case TEXT_ALIGNMENT_RIGHT:
      return drawing::TextAlignment::kRight;
    default:
      return drawing::TextAlignment::kLeft;
  }
}

}  // namespace

MadePoints MakeDrawing(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits,
                       std::vector<std::string>& warnings) {
  const std::string& name = input.model.file();
  auto drawing = INTAGLIO_TRY(ReadDrawing(name, file, limits.drawings));
  for (const auto& [kind, count] : drawing.left_out) {
    warnings.push_back(fmt::format("{}: left out {} entities: {}",
                                   std::filesystem::path(name).filename().string(), count,
                                   kind));
  }
  return PointsOf(method, input, drawing, discretize::CurveFill::kEvenOdd);
}

MadePoints MakeText(const Method& method, const MethodInput& input,
                    const std::string& text, std::string_view font) {
  const Text& asked = input.model.text();
  drawing::TextOptions options;
  options.font = asked.font();
  options.font_bytes = font;
  options.cap_height_mm = asked.height_mm();
  options.line_spacing_ratio = asked.line_ratio();
  options.alignment = AlignmentOf(asked.alignment());
  const auto outline = INTAGLIO_TRY(drawing::TextOutline(text, options));
  return PointsOf(method, input, outline, discretize::CurveFill::kNonZero);
}

MadePoints MakePicture(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits) {
  const auto& maker = std::get<PictureMaker>(method.make);
  image::ImageOptions reading;
  reading.limits = limits.images;
  reading.samples = maker.samples;
  const auto picture = INTAGLIO_TRY(image::ParseImage(file, reading));
  return maker.make(input, picture);
}

}  // namespace intaglio
