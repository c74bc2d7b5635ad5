// The methods that make points of pictures: as mesh_methods.cc.

#include <fmt/format.h>

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

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
      .layer_field = "layer_distance_mm",
      .layer_count_field = "layer_count",
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.halftone()); },
  };
}

// ---- relief --------------------------------------------------------------------------

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
      .layer_field = "layer_distance_mm",
      .layer_count_field = "layer_count",
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.relief()); },
  };
}

}  // namespace

std::vector<Method> PictureMethods() { return {Halftone(), Relief()}; }

}  // namespace intaglio
