// The methods that make points of pictures: as mesh_methods.cc.

#include <fmt/format.h>

#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/picture/halftone.h"
#include "engrave/discretize/picture/relief.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

/// A pixel is a distance wide; the placement scales that.
constexpr discretize::PanelSize kPixels{discretize::PanelSize::Rule::kPixel, 0, 0};

// ---- what both have ------------------------------------------------------------------

constexpr MethodField kDistance{
    "distance_mm", kPointDistanceMm, MinSpacing(), "--vertex",
    "minimum distance in a layer; width of a pixel before the placement"};
constexpr MethodField kBrightness{"brightness", NumberRange{-1, 1}, Number(0),
                                  "--brightness", "of the photo, as in photo editors"};
constexpr MethodField kContrast{"contrast_ratio", NumberRange{0, 10}, Number(1),
                                "--contrast", "of the photo, about the middle"};
constexpr MethodField kGamma{"gamma", NumberRange{0.1, 10}, Number(1), "--gamma",
                             "of the photo"};
constexpr MethodField kCurve{
    "curve",
    {},
    {},
    "--tone-curve",
    "maps brightness, linear between places {from to} of 0..1, from rising"};
constexpr MethodField kLayerCount{"layer_count", NumberRange{1, 10}, Number(1),
                                  "--layer-count", "number of layers above one another"};
constexpr MethodField kLayerDistance{"layer_distance_mm", NumberRange{0.01, 50},
                                     Times(2, "distance_mm"), "--layer",
                                     "distance of the layers"};

/// The fields have one name in both.
template <typename Options, typename Message>
Options PictureOptionsOf(const JobSpec& job, const Message& asked) {
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

Result<mesh::GlassFromModel> PlacementOfPanel(const MethodInput& input,
                                              const image::GreyImage& picture,
                                              double distance_mm) {
  const auto size_mm =
      INTAGLIO_TRY(discretize::PanelSizeOf(picture, kPixels, distance_mm));
  return mesh::GlassFromModelOf(discretize::PanelCorners(size_mm, 0), input.placement,
                                input.block_size_mm);
}

// The number of a picture's points is its brightness: none may be lost to thinning.
template <typename Message>
std::vector<MethodFault> ToneFaults(const JobSpec& job, const Message& asked) {
  std::vector<MethodFault> faults;
  const double spacing_mm = job.discretization().min_spacing_mm();
  if (asked.distance_mm() < spacing_mm) {
    faults.push_back({"distance_mm", fmt::format("{}", asked.distance_mm()),
                      fmt::format("is less than the minimum spacing, {}: thinning would "
                                  "remove points and change the tone",
                                  spacing_mm)});
  }
  for (int i = 1; i < asked.curve_size(); ++i) {
    const double before = asked.curve(i - 1).from(), from = asked.curve(i).from();
    if (from > before) continue;
    faults.push_back({fmt::format("curve[{}].from", i), fmt::format("{}", from),
                      fmt::format("is not above the previous one, {}", before)});
  }
  return faults;
}

// ---- halftone ------------------------------------------------------------------------

MadePoints MakeFromHalftone(const MethodInput& input, const image::GreyImage& picture) {
  const HalftoneMethod& asked = input.model.halftone();
  auto options = PictureOptionsOf<discretize::HalftoneOptions>(input.job, asked);
  options.method = asked.tone() == TONE_THRESHOLD ? discretize::HalftoneMethod::kThreshold
                   : asked.tone() == TONE_ERROR_DIFFUSION
                       ? discretize::HalftoneMethod::kErrorDiffusion
                       : discretize::HalftoneMethod::kBlueNoise;
  options.tone.invert = asked.invert();
  options.threshold = asked.threshold_ratio();
  // Where one layer becomes full and the next begins a line would be seen.
  options.sharing = discretize::LayerSharing::kEven;
  options.target_point_count = asked.point_count();
  const auto placement =
      INTAGLIO_TRY(PlacementOfPanel(input, picture, options.vertex_distance_mm));
  return discretize::MakeHalftone(picture, placement, options);
}

Method Halftone() {
  return {
      .number = Model::kHalftone,
      .kinds = {ModelKind::kImage},
      .default_of = {ModelKind::kImage},
      .meaning = "a photo as a flat panel, points follow the brightness",
      .fields = {{"tone", {}, {}, "--tone", "how brightness becomes points"},
                 {"invert", {}, {}, "--invert", "the negative"},
                 kDistance,
                 {"threshold_ratio", NumberRange{0, 1}, Number(0.5), "--threshold",
                  "brightness from which _THRESHOLD makes points"},
                 kBrightness,
                 kContrast,
                 kGamma,
                 kLayerCount,
                 kLayerDistance,
                 {"point_count",
                  NumberRange{1, 20000000},
                  {},
                  "--point-count",
                  "approximate number of points; without it as bright as possible"},
                 kCurve},
      .make = PictureMaker{image::Samples::kLinearLight, MakeFromHalftone},
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.halftone()); },
  };
}

// ---- relief --------------------------------------------------------------------------

MadePoints MakeFromRelief(const MethodInput& input, const image::GreyImage& depth_map) {
  const ReliefMethod& asked = input.model.relief();
  auto options = PictureOptionsOf<discretize::ReliefOptions>(input.job, asked);
  options.depth_mm = asked.depth_mm();
  options.white_is_near = !asked.invert();
  options.smoothing_mm = asked.smoothing_mm();
  const auto placement =
      INTAGLIO_TRY(PlacementOfPanel(input, depth_map, options.vertex_distance_mm));
  // A fit is of the panel; the depth is meant in the glass.
  const double scale = placement.linear.col(2).norm();
  if (scale > 0) options.depth_mm /= scale;
  std::optional<image::GreyImage> photo;
  if (!asked.photo().empty()) photo = input.images.at("photo");
  return discretize::MakeRelief(depth_map, photo, placement, options);
}

Method Relief() {
  return {
      .number = Model::kRelief,
      .kinds = {ModelKind::kImage},
      .meaning = "an image as a depth map",
      .fields =
          {{"depth_mm", NumberRange{0.1, 500}, Number(10), "--depth",
            "from the darkest to the brightest"},
           {"invert", {}, {}, "--invert", "dark pixels in front"},
           {"photo",
            {},
            {},
            "--photo",
            "a second image: brighter pixels get more points",
            true},
           kDistance,
           kGamma,
           kBrightness,
           kContrast,
           kCurve,
           kLayerCount,
           kLayerDistance,
           {"smoothing_mm", NumberRange{0, 10}, Number(0), "--smoothing",
            "mean over squares of this side; smooths the steps of maps with 256 depths"}},
      .make = PictureMaker{image::Samples::kAsStored, MakeFromRelief},
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.relief()); },
  };
}

}  // namespace

std::vector<Method> PictureMethods() { return {Halftone(), Relief()}; }

}  // namespace intaglio
