#include "services/job/models/flat_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include "engrave/discretize/drawing/curve_points.h"
#include "engrave/discretize/drawing/place_drawing.h"
#include "engrave/discretize/picture/halftone.h"
#include "engrave/discretize/picture/relief.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/svg/svg_read.h"
#include "engrave/image/image_file.h"
#include "engrave/image/resample.h"
#include "services/job/channels.h"
#include "services/job/options.h"

namespace intaglio {
namespace {

using Source = std::unique_ptr<discretize::PointSource>;

Result<Source> PointsOf(const JobSpec& job, const Model& model,
                        const drawing::Drawing& drawing, discretize::CurveFill fill) {
  const Block block = BlockOf(job, model);
  const auto placed = discretize::PlaceDrawing(
      drawing, PlacementOf(model.placement(), block), Vec3Of(block.size_mm()));
  if (!placed) return tl::unexpected(placed.error());
  const CurvesMethod& asked = model.curves();
  discretize::CurveOptions options;
  options.distance_mm = asked.distance_mm();
  options.layer_count = static_cast<int>(asked.layer_count());
  options.layer_distance_mm = asked.layer_distance_mm();
  options.layer_direction = placed->normal;
  options.twist_phase_ratio = asked.twist_phase_ratio();
  options.insert_end_points = asked.insert_end_points();
  if (asked.fill()) options.fill = fill;
  return discretize::MakeCurvePoints(placed->flat, options);
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

/// A pixel is a distance wide; the placement scales that.
constexpr discretize::PanelSize kPixels{discretize::PanelSize::Rule::kPixel, 0, 0};

Result<mesh::GlassFromModel> PlacementOfPicture(const JobSpec& job, const Model& model,
                                                const image::GreyImage& picture,
                                                double distance_mm, double thickness_mm) {
  const auto size_mm = discretize::PanelSizeOf(picture, kPixels, distance_mm);
  if (!size_mm) return tl::unexpected(size_mm.error());
  const Block block = BlockOf(job, model);
  return mesh::GlassFromModelOf(discretize::PanelCorners(*size_mm, thickness_mm),
                                PlacementOf(model.placement(), block),
                                Vec3Of(block.size_mm()));
}

/// What both methods of pictures have: the fields have one name in both.
template <typename Options, typename Method>
Options PictureOptionsOf(const JobSpec& job, const Method& asked) {
  Options options;
  options.size = kPixels;
  options.vertex_distance_mm = asked.distance_mm();
  options.layer_count = static_cast<int>(asked.layer_count());
  options.layer_distance_mm = asked.layer_distance_mm();
  options.tone.brightness = asked.brightness();
  options.tone.contrast_ratio = asked.contrast_ratio();
  options.tone.gamma = asked.gamma();
  for (const TonePoint& point : asked.curve())
    options.tone.points.emplace_back(point.from(), point.to());
  options.seed = job.seed();
  return options;
}

discretize::HalftoneOptions OptionsOf(const JobSpec& job, const HalftoneMethod& asked) {
  auto options = PictureOptionsOf<discretize::HalftoneOptions>(job, asked);
  options.method = asked.tone() == TONE_THRESHOLD ? discretize::HalftoneMethod::kThreshold
                   : asked.tone() == TONE_ERROR_DIFFUSION
                       ? discretize::HalftoneMethod::kErrorDiffusion
                       : discretize::HalftoneMethod::kBlueNoise;
  options.tone.invert = asked.invert();
  options.threshold = asked.threshold_ratio();
  // Where one layer becomes full and the next begins a line would be seen.
  options.sharing = discretize::LayerSharing::kEven;
  options.target_point_count = asked.point_count();
  return options;
}

}  // namespace

Result<Source> MakeDrawing(const JobSpec& job, const Model& model, std::string_view file,
                           const ReadLimits& limits, std::vector<std::string>& warnings) {
  const auto drawing = ReadDrawing(model.file(), file, limits.drawings);
  if (!drawing) return tl::unexpected(drawing.error());
  for (const auto& [kind, count] : drawing->left_out) {
    warnings.push_back(fmt::format(
        "{}: left out {} times: {}",
        std::filesystem::path(model.file()).filename().string(), count, kind));
  }
  return PointsOf(job, model, *drawing, discretize::CurveFill::kEvenOdd);
}

Result<Source> MakeText(const JobSpec& job, const Model& model, const std::string& text,
                        std::string_view font) {
  drawing::TextOptions options;
  options.font = model.text().font();
  options.font_bytes = font;
  options.cap_height_mm = model.text().height_mm();
  options.line_spacing_ratio = model.text().line_ratio();
  options.alignment = AlignmentOf(model.text().alignment());
  const auto outline = drawing::TextOutline(text, options);
  if (!outline) return tl::unexpected(outline.error());
  return PointsOf(job, model, *outline, discretize::CurveFill::kNonZero);
}

Result<Source> MakePicture(const JobSpec& job, const Model& model, std::string_view file,
                           std::optional<std::string_view> photo,
                           const ReadLimits& limits) {
  image::ImageOptions reading;
  reading.limits = limits.images;
  if (model.has_relief()) reading.samples = image::Samples::kAsStored;
  const auto picture = image::ParseImage(file, reading);
  if (!picture) return tl::unexpected(picture.error());
  if (model.has_halftone()) {
    const auto options = OptionsOf(job, model.halftone());
    const auto placement =
        PlacementOfPicture(job, model, *picture, options.vertex_distance_mm, 0);
    if (!placement) return tl::unexpected(placement.error());
    return discretize::MakeHalftone(*picture, *placement, options);
  }
  std::optional<image::GreyImage> shade;
  if (photo) {
    image::ImageOptions of_light;
    of_light.limits = limits.images;
    auto read = image::ParseImage(*photo, of_light);
    if (!read) {
      Error error = read.error();
      error.message = model.relief().photo() + ": " + error.message;
      return tl::unexpected(std::move(error));
    }
    shade = std::move(*read);
  }
  const ReliefMethod& asked = model.relief();
  auto options = PictureOptionsOf<discretize::ReliefOptions>(job, asked);
  options.depth_mm = asked.depth_mm();
  options.white_is_near = !asked.invert();
  options.smoothing_mm = asked.smoothing_mm();
  auto placement =
      PlacementOfPicture(job, model, *picture, options.vertex_distance_mm, 0);
  if (!placement) return tl::unexpected(placement.error());
  // A fit is of the panel; the depth is meant in the glass.
  const double scale = placement->linear.col(2).norm();
  if (scale > 0) options.depth_mm /= scale;
  return discretize::MakeRelief(*picture, shade, *placement, options);
}

Result<discretize::Density> DensityOfPicture(std::string_view file, const Box3& box_mm,
                                             const image::ImageLimits& limits) {
  image::ImageOptions reading;
  reading.limits = limits;
  const auto picture = image::ParseImage(file, reading);
  if (!picture) return tl::unexpected(picture.error());
  // Finer than any spacing; what is asked for is a value a point.
  constexpr int kLargest = 2048;
  const double shrink = std::min(
      1.0, static_cast<double>(kLargest) / std::max(picture->width, picture->height));
  auto values = std::make_shared<const image::FloatImage>(
      image::Resample(*picture, std::max(1, static_cast<int>(picture->width * shrink)),
                      std::max(1, static_cast<int>(picture->height * shrink))));
  const Vec3 size_mm = box_mm.size_mm().cwiseMax(1e-9);
  return discretize::DensityByPlace([=](const Vec3& p) {
    const Vec3 share = (p - box_mm.min_mm).cwiseQuotient(size_mm);
    return static_cast<double>(image::Interpolate(*values, share.x(), 1 - share.z()));
  });
}

}  // namespace intaglio
