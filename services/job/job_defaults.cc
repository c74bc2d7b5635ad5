#include "services/job/job_defaults.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "services/job/machine/machine_axes.h"
#include "services/job/model_kind.h"

namespace intaglio {
namespace {

constexpr double kDefaultMarginMm = 3;  // the source's objects are 3-5 mm smaller
constexpr double kDefaultFirstLastRatio = 0.1;
constexpr double kDefaultSparseRatio = 3;
constexpr double kDefaultReliefMm = 10;
constexpr double kDefaultTextMm = 5;
constexpr double kDefaultStageLagS = 0.0002;
constexpr std::uint32_t kDefaultMaxMissedInARow = 5;
constexpr std::uint32_t kDefaultBaud = 115200;
// Lens catalogues give focal lengths to 0.01 mm: nearer than this is the same lens.
constexpr double kSameFocalLengthMm = 1e-3;

Vector3 MakeVector(double x, double y, double z) {
  Vector3 v;
  v.set_x(x), v.set_y(y), v.set_z(z);
  return v;
}

std::string NameOf(const Model& model) {
  return model.has_text() ? model.text().text()
                          : std::filesystem::path(model.file()).filename().string();
}

/// A picture has no size of its own, and a cloud has its place already.
void PlaceByKind(const Model& model, Placement& placement) {
  const auto kind = KindOf(model);
  if (kind == ModelKind::kImage && !placement.has_unit_mm() &&
      placement.fit_case() == Placement::FIT_NOT_SET) {
    placement.set_fit_block(true);
  }
  if (kind == ModelKind::kCloud && !placement.has_centre_in_block()) {
    placement.set_centre_in_block(false);
  }
}

void FillPlacement(Placement& placement) {
  if (!placement.has_unit_mm()) placement.set_unit_mm(1);
  if (!placement.has_scale_ratio())
    *placement.mutable_scale_ratio() = MakeVector(1, 1, 1);
  if (!placement.has_rotate_deg()) *placement.mutable_rotate_deg() = MakeVector(0, 0, 0);
  if (!placement.has_move_mm()) *placement.mutable_move_mm() = MakeVector(0, 0, 0);
  if (!placement.has_centre_in_block()) placement.set_centre_in_block(true);
}

void Fill(SectionsMethod& sections, double spacing_mm) {
  if (!sections.has_layer_distance_mm()) sections.set_layer_distance_mm(spacing_mm);
  if (!sections.has_vertex_distance_mm()) sections.set_vertex_distance_mm(spacing_mm);
  if (!sections.has_first_last_distance_ratio()) {
    sections.set_first_last_distance_ratio(kDefaultFirstLastRatio);
  }
  if (!sections.has_twist_phase_ratio()) sections.set_twist_phase_ratio(0);
  if (!sections.has_insert_end_points()) sections.set_insert_end_points(true);
  if (!sections.has_rotate_deg()) *sections.mutable_rotate_deg() = MakeVector(0, 0, 0);
}

void Fill(FillMethod& fill, double spacing_mm) {
  if (!fill.has_vertex_distance_mm()) fill.set_vertex_distance_mm(spacing_mm);
  if (!fill.has_full_fill()) fill.set_full_fill(true);
}

void Fill(RaysMethod& rays, double spacing_mm) {
  if (!rays.has_distance_mm()) rays.set_distance_mm(spacing_mm);
  if (!rays.has_rotate_deg()) *rays.mutable_rotate_deg() = MakeVector(0, 0, 0);
}

void Fill(EvenMethod& even, double spacing_mm) {
  if (!even.has_distance_mm()) even.set_distance_mm(spacing_mm);
  if (even.shell_depths_mm().empty()) even.add_shell_depths_mm(0);
  if (!even.has_sparse_distance_mm()) {
    even.set_sparse_distance_mm(kDefaultSparseRatio * even.distance_mm());
  }
}

void Fill(SolidMethod& solid, double spacing_mm) {
  if (!solid.has_distance_mm()) solid.set_distance_mm(spacing_mm);
}

void Fill(CurvesMethod& curves, double spacing_mm) {
  if (!curves.has_distance_mm()) curves.set_distance_mm(spacing_mm);
  if (!curves.has_layer_count()) curves.set_layer_count(1);
  if (!curves.has_layer_distance_mm()) curves.set_layer_distance_mm(spacing_mm);
  if (!curves.has_twist_phase_ratio()) curves.set_twist_phase_ratio(0);
  if (!curves.has_insert_end_points()) curves.set_insert_end_points(true);
}

/// What both methods of pictures have.
template <typename Method>
void FillPicture(Method& method, double spacing_mm) {
  if (!method.has_distance_mm()) method.set_distance_mm(spacing_mm);
  if (!method.has_brightness()) method.set_brightness(0);
  if (!method.has_contrast_ratio()) method.set_contrast_ratio(1);
  if (!method.has_gamma()) method.set_gamma(1);
  if (!method.has_layer_count()) method.set_layer_count(1);
  if (!method.has_layer_distance_mm())
    method.set_layer_distance_mm(2 * method.distance_mm());
}

void Fill(HalftoneMethod& halftone, double spacing_mm) {
  FillPicture(halftone, spacing_mm);
  if (!halftone.has_threshold_ratio()) halftone.set_threshold_ratio(0.5);
}

void Fill(ReliefMethod& relief, double spacing_mm) {
  FillPicture(relief, spacing_mm);
  if (!relief.has_depth_mm()) relief.set_depth_mm(kDefaultReliefMm);
  if (!relief.has_smoothing_mm()) relief.set_smoothing_mm(0);
}

/// The method of meshes that say nothing else.
void FillDiscretization(Discretization& discretization) {
  if (!discretization.has_height_ratio()) discretization.set_height_ratio(1);
  const double spacing_mm = discretization.min_spacing_mm();
  switch (discretization.method_case()) {
    case Discretization::METHOD_NOT_SET:
    case Discretization::kSections:
      return Fill(*discretization.mutable_sections(), spacing_mm);
    case Discretization::kFill:
      return Fill(*discretization.mutable_fill(), spacing_mm);
    case Discretization::kRays:
      return Fill(*discretization.mutable_rays(), spacing_mm);
    case Discretization::kEven:
      return Fill(*discretization.mutable_even(), spacing_mm);
    case Discretization::kSolid:
      return Fill(*discretization.mutable_solid(), spacing_mm);
  }
}

void ChooseMethod(Model& model, const Discretization& of_meshes) {
  const auto kind = KindOf(model);
  if (!kind) return;  // the check says so
  if (*kind == ModelKind::kDrawing || *kind == ModelKind::kText) model.mutable_curves();
  if (*kind == ModelKind::kImage) model.mutable_halftone();
  if (*kind != ModelKind::kMesh) return;
  switch (of_meshes.method_case()) {
    case Discretization::METHOD_NOT_SET:
      break;
    case Discretization::kSections:
      *model.mutable_sections() = of_meshes.sections();
      break;
    case Discretization::kFill:
      *model.mutable_fill() = of_meshes.fill();
      break;
    case Discretization::kRays:
      *model.mutable_rays() = of_meshes.rays();
      break;
    case Discretization::kEven:
      *model.mutable_even() = of_meshes.even();
      break;
    case Discretization::kSolid:
      *model.mutable_solid() = of_meshes.solid();
      break;
  }
}

void FillMethodOf(Model& model, double spacing_mm) {
  switch (model.method_case()) {
    case Model::METHOD_NOT_SET:
      break;
    case Model::kSections:
      return Fill(*model.mutable_sections(), spacing_mm);
    case Model::kFill:
      return Fill(*model.mutable_fill(), spacing_mm);
    case Model::kRays:
      return Fill(*model.mutable_rays(), spacing_mm);
    case Model::kEven:
      return Fill(*model.mutable_even(), spacing_mm);
    case Model::kSolid:
      return Fill(*model.mutable_solid(), spacing_mm);
    case Model::kCurves:
      return Fill(*model.mutable_curves(), spacing_mm);
    case Model::kHalftone:
      return Fill(*model.mutable_halftone(), spacing_mm);
    case Model::kRelief:
      return Fill(*model.mutable_relief(), spacing_mm);
  }
}

void FillModel(Model& model, const Discretization& discretization) {
  PlaceByKind(model, *model.mutable_placement());
  FillPlacement(*model.mutable_placement());
  if (model.has_text()) {
    Text& text = *model.mutable_text();
    if (!text.has_height_mm()) text.set_height_mm(kDefaultTextMm);
    if (!text.has_line_ratio()) text.set_line_ratio(1);
  }
  if (model.has_copies()) {
    Copies& copies = *model.mutable_copies();
    if (!copies.has_count_x()) copies.set_count_x(1);
    if (!copies.has_count_y()) copies.set_count_y(1);
    if (!copies.has_count_z()) copies.set_count_z(1);
    if (!copies.has_step_mm()) *copies.mutable_step_mm() = MakeVector(0, 0, 0);
  }
  if (model.method_case() == Model::METHOD_NOT_SET) ChooseMethod(model, discretization);
  FillMethodOf(model, discretization.min_spacing_mm());
}

void FillOrdering(Ordering& ordering, double spacing_mm) {
  if (ordering.method_case() == Ordering::METHOD_NOT_SET) ordering.mutable_anneal();
  if (ordering.has_layers() && !ordering.layers().has_layer_thickness_mm()) {
    ordering.mutable_layers()->set_layer_thickness_mm(spacing_mm);
  }
  if (ordering.has_anneal()) {
    AnnealOrder& anneal = *ordering.mutable_anneal();
    if (!anneal.has_tries_per_point()) anneal.set_tries_per_point(30);
    if (!anneal.has_seed()) anneal.set_seed(1);
  }
  if (ordering.has_boustrophedon()) {
    BoustrophedonOrder& rows = *ordering.mutable_boustrophedon();
    if (!rows.has_layer_thickness_mm()) rows.set_layer_thickness_mm(spacing_mm);
    if (!rows.has_row_width_mm()) rows.set_row_width_mm(spacing_mm);
  }
  if (ordering.has_published_kdz()) {
    PublishedKdzOrder& published = *ordering.mutable_published_kdz();
    if (!published.has_up_ratio()) published.set_up_ratio(1);
    if (!published.has_down_ratio()) published.set_down_ratio(1);
  }
}

void FillMotion(MotionOptions& motion, const MachineSpec& machine) {
  const FocusLimits limits = FocusLimitsOf(machine);
  if (!motion.has_max_speed_mm_s()) motion.set_max_speed_mm_s(limits.speed_mm_s);
  if (!motion.has_max_acceleration_mm_s2()) {
    motion.set_max_acceleration_mm_s2(limits.acceleration_mm_s2);
  }
  if (!motion.has_tolerance_um()) motion.set_tolerance_um(0);
}

void FillLaser(LaserOptions& laser, const LaserHead& head) {
  if (!laser.has_rate_hz() && head.rates_hz_size() > 0) {
    laser.set_rate_hz(*std::max_element(head.rates_hz().begin(), head.rates_hz().end()));
  }
  if (!laser.has_wavelength_nm()) laser.set_wavelength_nm(head.wavelength_nm());
  if (!laser.has_pulse_energy_mj()) laser.set_pulse_energy_mj(head.pulse_energy_mj());
  if (laser.channels().empty()) laser.add_channels(1);
  if (!laser.has_photosensor_feedback()) laser.set_photosensor_feedback(true);
}

void FillChannels(JobSpec& job) {
  for (Model& model : *job.mutable_models()) {
    if (!model.channels().empty()) continue;
    for (const std::uint32_t channel : job.laser().channels()) {
      const auto& known = model.channels();
      if (std::find(known.begin(), known.end(), channel) == known.end()) {
        model.add_channels(channel);
      }
    }
  }
}

void FillLens(Lens& lens, const MachineSpec& machine) {
  if (!lens.has_focal_length_mm() && machine.lenses_size() > 0) {
    lens.set_focal_length_mm(machine.lenses(0).focal_length_mm());
  }
  const MachineLens* mounted = FindLens(machine, lens.focal_length_mm());
  if (!lens.has_numerical_aperture() && mounted != nullptr) {
    lens.set_numerical_aperture(mounted->numerical_aperture());
  }
}

}  // namespace

const MachineLens* FindLens(const MachineSpec& machine, double focal_length_mm) {
  for (const MachineLens& lens : machine.lenses()) {
    if (std::abs(lens.focal_length_mm() - focal_length_mm) < kSameFocalLengthMm)
      return &lens;
  }
  return nullptr;
}

JobSpec WithDefaults(JobSpec job, const MachineSpec& machine) {
  if (job.name().empty() && job.models_size() > 0) job.set_name(NameOf(job.models(0)));
  if (!job.block().has_margin_mm()) job.mutable_block()->set_margin_mm(kDefaultMarginMm);
  FillLens(*job.mutable_lens(), machine);
  FillDiscretization(*job.mutable_discretization());
  for (Model& model : *job.mutable_models()) FillModel(model, job.discretization());
  FillOrdering(*job.mutable_ordering(), job.discretization().min_spacing_mm());
  FillMotion(*job.mutable_motion(), machine);
  FillLaser(*job.mutable_laser(), machine.laser());
  FillChannels(job);
  return job;
}

MachineSpec WithMachineDefaults(MachineSpec machine) {
  for (SerialLine* line : {machine.mutable_laser_line(), machine.mutable_motion_line()}) {
    if (!line->has_baud()) line->set_baud(kDefaultBaud);
  }
  if (!machine.has_stage_lag_s()) machine.set_stage_lag_s(kDefaultStageLagS);
  if (machine.has_laser() && !machine.laser().has_max_missed_in_a_row()) {
    machine.mutable_laser()->set_max_missed_in_a_row(kDefaultMaxMissedInARow);
  }
  return machine;
}

}  // namespace intaglio
