// How the methods of pictures make points: as mesh_makers.cc.

#include <optional>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/picture/halftone.h"
#include "engrave/discretize/picture/relief.h"
#include "engrave/mesh/plausible_size.h"
#include "services/job/methods/point_maker.h"

namespace intaglio {
namespace {

/// A pixel is a distance wide; the placement scales that.
constexpr discretize::PanelSize kPixels{discretize::PanelSize::Rule::kPixel, 0, 0};

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

/// By its bounding box, before the panel is sampled.
Status RefuseHugePanel(const MethodInput& input, const PointList& corners_mm,
                       const mesh::GlassFromModel& placement) {
  Box3 box;
  for (const Vec3& corner : corners_mm) box.Extend(placement.Apply(corner));
  const auto fault = mesh::FindSizeFault(
      {.size_mm = box.size_mm(),
       .block_size_mm = input.block_size_mm,
       .unit_mm = input.placement.unit_mm,
       .fitted = input.model.placement().fit_case() != Placement::FIT_NOT_SET,
       .clip = input.job.block().clip()},
      input.model.file());
  if (!fault || !fault->refused) return {};
  return Fail(ErrorCode::kOutsideBlock, fault->warning.text);
}

Result<mesh::GlassFromModel> PlacementOfPanel(const MethodInput& input,
                                              const image::GreyImage& picture,
                                              double distance_mm) {
  const auto size_mm =
      INTAGLIO_TRY(discretize::PanelSizeOf(picture, kPixels, distance_mm));
  const PointList corners_mm = discretize::PanelCorners(size_mm, 0);
  const auto placement = INTAGLIO_TRY(
      mesh::GlassFromModelOf(corners_mm, input.placement, input.block_size_mm));
  INTAGLIO_TRY(RefuseHugePanel(input, corners_mm, placement));
  return placement;
}

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

}  // namespace

std::vector<PointMaker> PictureMakers() {
  return {
      {Model::kHalftone, PictureMaker{image::Samples::kLinearLight, MakeFromHalftone}},
      {Model::kRelief, PictureMaker{image::Samples::kAsStored, MakeFromRelief}}};
}

}  // namespace intaglio
