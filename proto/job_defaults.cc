#include "proto/job_defaults.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace intaglio {
namespace {

constexpr double kDefaultMarginMm = 3;  // the source's objects are 3-5 mm smaller
constexpr double kDefaultFirstLastRatio = 0.1;
constexpr double kDefaultStageLagS = 0.0002;
constexpr std::uint32_t kDefaultBaud = 115200;
// Lens catalogues give focal lengths to 0.01 mm: nearer than this is the same lens.
constexpr double kSameFocalLengthMm = 1e-3;

Vector3 MakeVector(double x, double y, double z) {
  Vector3 v;
  v.set_x(x), v.set_y(y), v.set_z(z);
  return v;
}

void FillPlacement(Placement& placement) {
  if (!placement.has_unit_mm()) placement.set_unit_mm(1);
  if (!placement.has_scale_ratio())
    *placement.mutable_scale_ratio() = MakeVector(1, 1, 1);
  if (!placement.has_rotate_deg()) *placement.mutable_rotate_deg() = MakeVector(0, 0, 0);
  if (!placement.has_move_mm()) *placement.mutable_move_mm() = MakeVector(0, 0, 0);
  if (!placement.has_centre_in_block()) placement.set_centre_in_block(true);
}

void FillSections(SectionsMethod& sections, double spacing_mm) {
  if (!sections.has_layer_distance_mm()) sections.set_layer_distance_mm(spacing_mm);
  if (!sections.has_vertex_distance_mm()) sections.set_vertex_distance_mm(spacing_mm);
  if (!sections.has_first_last_distance_ratio()) {
    sections.set_first_last_distance_ratio(kDefaultFirstLastRatio);
  }
  if (!sections.has_twist_phase_ratio()) sections.set_twist_phase_ratio(0);
  if (!sections.has_insert_end_points()) sections.set_insert_end_points(true);
  if (!sections.has_rotate_deg()) *sections.mutable_rotate_deg() = MakeVector(0, 0, 0);
}

void FillDiscretization(Discretization& discretization) {
  const double spacing_mm = discretization.min_spacing_mm();
  switch (discretization.method_case()) {
    case Discretization::kSections:
    case Discretization::METHOD_NOT_SET:
      FillSections(*discretization.mutable_sections(), spacing_mm);
      break;
    case Discretization::kFill: {
      FillMethod& fill = *discretization.mutable_fill();
      if (!fill.has_vertex_distance_mm()) fill.set_vertex_distance_mm(spacing_mm);
      if (!fill.has_full_fill()) fill.set_full_fill(true);
      break;
    }
    case Discretization::kRays: {
      RaysMethod& rays = *discretization.mutable_rays();
      if (!rays.has_distance_mm()) rays.set_distance_mm(spacing_mm);
      if (!rays.has_rotate_deg()) *rays.mutable_rotate_deg() = MakeVector(0, 0, 0);
      break;
    }
  }
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
  if (!motion.has_max_speed_mm_s()) {
    motion.set_max_speed_mm_s(
        std::max({machine.x().max_speed_mm_s(), machine.y().max_speed_mm_s(),
                  machine.z().max_speed_mm_s()}));
  }
  if (!motion.has_max_acceleration_mm_s2()) {
    motion.set_max_acceleration_mm_s2(std::max({machine.x().max_acceleration_mm_s2(),
                                                machine.y().max_acceleration_mm_s2(),
                                                machine.z().max_acceleration_mm_s2()}));
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
  if (job.name().empty() && job.models_size() > 0) {
    job.set_name(std::filesystem::path(job.models(0).file()).filename().string());
  }
  for (Model& model : *job.mutable_models()) FillPlacement(*model.mutable_placement());
  if (!job.block().has_margin_mm()) job.mutable_block()->set_margin_mm(kDefaultMarginMm);
  FillLens(*job.mutable_lens(), machine);
  FillDiscretization(*job.mutable_discretization());
  FillOrdering(*job.mutable_ordering(), job.discretization().min_spacing_mm());
  FillMotion(*job.mutable_motion(), machine);
  FillLaser(*job.mutable_laser(), machine.laser());
  return job;
}

MachineSpec WithMachineDefaults(MachineSpec machine) {
  for (SerialLine* line : {machine.mutable_laser_line(), machine.mutable_motion_line()}) {
    if (!line->has_baud()) line->set_baud(kDefaultBaud);
  }
  if (!machine.has_stage_lag_s()) machine.set_stage_lag_s(kDefaultStageLagS);
  return machine;
}

}  // namespace intaglio
