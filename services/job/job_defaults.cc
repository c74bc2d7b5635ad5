#include "services/job/job_defaults.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "engrave/io/lower_case.h"
#include "engrave/optics/pulse_focus.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/marks_check.h"
#include "services/job/methods/method_table.h"
#include "services/job/model_kind.h"
#include "services/job/placeholders.h"

namespace intaglio {
namespace {

constexpr double kThinnestSlabMm = 0.01;  // of SweepOrder
constexpr double kDefaultMarginMm = 3;    // the source's objects are 3-5 mm smaller
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
  return IsText(model)      ? NumberedText(model.text().text(), 1)
         : model.has_code() ? model.code().text()
         : model.file().empty() && model.points_mm_size() > 0
             ? "points"
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

/// Upright, by what the format defines; a model that is given a rotation is rotated from
/// how it lies in its file.
UpAxis UpOf(const Model& model) {
  const auto kind = KindOf(model);
  if (!kind || model.placement().has_rotate_deg()) return UP_AXIS_Z;
  switch (*kind) {
    case ModelKind::kDrawing:
    case ModelKind::kText:
    case ModelKind::kImage:
    case ModelKind::kCode:
      return UP_AXIS_Y;
    case ModelKind::kMesh:
      break;
    case ModelKind::kCloud:
      return UP_AXIS_Z;
  }
  const std::string extension =
      io::LowerCaseExtension(std::filesystem::path(model.file()).extension().string());
  if (extension == "gltf" || extension == "glb") return UP_AXIS_Y;
  return extension == "dae" ? UP_AXIS_DECLARED : UP_AXIS_Z;
}

void FillPlacement(const Model& model, Placement& placement) {
  if (!placement.has_unit_mm() && !MayDeclareUnit(model)) placement.set_unit_mm(1);
  if (!placement.has_scale_ratio())
    *placement.mutable_scale_ratio() = MakeVector(1, 1, 1);
  if (!placement.has_rotate_deg()) *placement.mutable_rotate_deg() = MakeVector(0, 0, 0);
  if (!placement.has_move_mm()) *placement.mutable_move_mm() = MakeVector(0, 0, 0);
  if (!placement.has_centre_in_block()) placement.set_centre_in_block(true);
}

/// The method of a Model or a Discretization; nothing when it has none.
void FillChosen(google::protobuf::Message& holder, double spacing_mm) {
  const Method* method = MethodOf(holder);
  if (method == nullptr) return;
  FillDefaults(*method, spacing_mm, MutableMessageOf(*method, holder));
}

/// The method of meshes that name none.
void FillDiscretization(Discretization& discretization) {
  if (!discretization.has_height_ratio()) discretization.set_height_ratio(1);
  if (MethodOf(discretization) == nullptr) {
    MutableMessageOf(*DefaultMethodOf(ModelKind::kMesh), discretization);
  }
  FillChosen(discretization, discretization.min_spacing_mm());
}

void ChooseMethod(Model& model, const Discretization& of_meshes) {
  const auto kind = KindOf(model);
  if (!kind) return;  // the check reports it
  if (*kind == ModelKind::kMesh) {
    if (const Method* method = MethodOf(of_meshes)) {
      MutableMessageOf(*method, model).CopyFrom(MessageOf(*method, of_meshes));
    }
  } else if (const Method* method = DefaultMethodOf(*kind)) {
    MutableMessageOf(*method, model);
  }
}

void FillModel(Model& model, const Discretization& discretization) {
  PlaceByKind(model, *model.mutable_placement());
  if (model.placement().up() == UP_AXIS_DEFAULT) {
    model.mutable_placement()->set_up(UpOf(model));
  }
  FillPlacement(model, *model.mutable_placement());
  if (IsText(model)) {
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
  if (model.has_code()) FillCode(*model.mutable_code());
  if (model.method_case() == Model::METHOD_NOT_SET) ChooseMethod(model, discretization);
  FillChosen(model, discretization.min_spacing_mm());
}

/// `motion`: with its defaults.
void FillOrdering(Ordering& ordering, double spacing_mm, const MotionOptions& motion,
                  const MachineSpec& machine) {
  if (ordering.method_case() == Ordering::METHOD_NOT_SET) {
    if (machine.head_over_block().has_jump_and_dwell()) {
      ordering.mutable_jump_layers();
    } else if (machine.has_head_over_block()) {
      ordering.mutable_sweep();
    } else {
      ordering.mutable_anneal();
    }
  }
  if (ordering.has_sweep() && !ordering.sweep().has_slab_mm()) {
    ordering.mutable_sweep()->set_slab_mm(
        std::max(kThinnestSlabMm, 1e-3 * motion.depth_tolerance_um()));
  }
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
    if (published.has_angle_deg()) return;
    if (!published.has_up_ratio()) published.set_up_ratio(1);
    if (!published.has_down_ratio()) published.set_down_ratio(1);
  }
}

/// Of the crack's length: with what remains of lag and aberration, a crack is within a
/// tenth of its length.
constexpr double kDepthToleranceRatio = 1.0 / 20;

double DefaultDepthToleranceUm(const Lens& lens, const MachineSpec& machine) {
  const MachineLens* mounted = FindLens(machine, lens.focal_length_mm());
  if (!machine.has_head_over_block() || mounted == nullptr) return 0;
  // z rests at its steps, and has no way to sweep.
  if (machine.head_over_block().has_jump_and_dwell()) return 0;
  return 1e3 * kDepthToleranceRatio * mounted->crack_length_mm();
}

void FillMotion(MotionOptions& motion, const Lens& lens, const MachineSpec& machine) {
  const FocusLimits limits = FocusLimitsOf(machine);
  if (!motion.has_max_speed_mm_s()) motion.set_max_speed_mm_s(limits.speed_mm_s);
  if (!motion.has_max_acceleration_mm_s2()) {
    motion.set_max_acceleration_mm_s2(limits.acceleration_mm_s2);
  }
  if (!motion.has_tolerance_um()) motion.set_tolerance_um(0);
  if (!motion.has_depth_tolerance_um()) {
    motion.set_depth_tolerance_um(DefaultDepthToleranceUm(lens, machine));
  }
  if (!motion.has_lq()) return;
  LqWeights& lq = *motion.mutable_lq();
  if (!lq.has_moving_mass_kg()) lq.set_moving_mass_kg(1);
  if (!lq.has_friction_n_s_m()) lq.set_friction_n_s_m(0);
  if (!lq.has_speed_weight()) lq.set_speed_weight(0);
  if (!lq.has_force_weight()) lq.set_force_weight(1);
}

void FillLaser(LaserOptions& laser, const LaserHead& head) {
  if (!laser.has_rate_hz() && head.rates_hz_size() > 0)
    laser.set_rate_hz(DefaultRateHz(head));
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
  if (const MachineLens* own = MountedLensOf(machine);
      own != nullptr && !lens.has_focal_length_mm()) {
    lens.set_focal_length_mm(own->focal_length_mm());
  }
  const MachineLens* mounted = FindLens(machine, lens.focal_length_mm());
  if (!lens.has_numerical_aperture() && mounted != nullptr) {
    lens.set_numerical_aperture(mounted->numerical_aperture());
  }
}

/// Proposed by the lens: its crack's diameter, down to 0.01 mm. So 0.09 mm with f = 43 mm
/// and 0.13 mm with f = 70 mm, as published (Trochimczuk 2008, annex A, 6).
void FillSpacing(const Lens& lens, const MachineSpec& machine,
                 Discretization& discretization) {
  constexpr double kStepsPerMm = 100, kRounding = 1e-9, kMinMm = 0.02;
  const MachineLens* mounted = FindLens(machine, lens.focal_length_mm());
  if (discretization.has_min_spacing_mm() || mounted == nullptr) return;
  if (mounted->crack_diameter_mm() <= 0) return;
  const double steps = std::floor(kStepsPerMm * mounted->crack_diameter_mm() + kRounding);
  discretization.set_min_spacing_mm(std::max(kMinMm, steps / kStepsPerMm));
}

// Trochimczuk 2008, ch. 6.6.2: the servo cycle of its planar drives.
constexpr double kDefaultPlanarPeriodS = 0.0002;

void FillPlanar(PlanarDrive& drive) {
  if (!drive.has_period_s()) drive.set_period_s(kDefaultPlanarPeriodS);
}

/// Gives a beam that fills no lens half of its width over the focal length.
void FillApertures(MachineSpec& machine) {
  const double beam_mm = machine.laser().beam_diameter_mm();
  for (MachineLens& lens : *machine.mutable_lenses()) {
    if (lens.has_numerical_aperture() || beam_mm <= 0 || lens.focal_length_mm() <= 0)
      continue;
    lens.set_numerical_aperture(optics::ApertureOfBeam(beam_mm, lens.focal_length_mm()));
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

double DefaultRateHz(const LaserHead& head) {
  if (head.has_default_rate_hz()) return head.default_rate_hz();
  const auto highest = std::ranges::max_element(head.rates_hz());
  return highest == head.rates_hz().end() ? 0 : *highest;
}

JobSpec WithDefaults(JobSpec job, const MachineSpec& machine) {
  if (job.has_marks()) {
    *job.mutable_marks() = WithDefaults(std::move(*job.mutable_marks()));
    if (job.name().empty()) job.set_name("marks");
    return job;
  }
  if (job.name().empty() && job.models_size() > 0) job.set_name(NameOf(job.models(0)));
  if (!job.block().has_margin_mm()) job.mutable_block()->set_margin_mm(kDefaultMarginMm);
  FillLens(*job.mutable_lens(), machine);
  FillSpacing(job.lens(), machine, *job.mutable_discretization());
  FillDiscretization(*job.mutable_discretization());
  for (Model& model : *job.mutable_models()) FillModel(model, job.discretization());
  FillMotion(*job.mutable_motion(), job.lens(), machine);
  FillOrdering(*job.mutable_ordering(), job.discretization().min_spacing_mm(),
               job.motion(), machine);
  FillLaser(*job.mutable_laser(), machine.laser());
  FillChannels(job);
  if (machine.has_loading() && !job.has_station()) job.set_station(1);
  return job;
}

MachineSpec WithMachineDefaults(MachineSpec machine) {
  if (machine.has_mark_line()) {
    SerialLine& line = *machine.mutable_mark_line();
    if (!line.has_baud()) line.set_baud(kDefaultBaud);
    return machine;
  }
  for (SerialLine* line : {machine.mutable_laser_line(), machine.mutable_motion_line()}) {
    if (!line->has_baud()) line->set_baud(kDefaultBaud);
  }
  if (machine.drive_case() == MachineSpec::DRIVE_NOT_SET)
    machine.set_stage_lag_s(kDefaultStageLagS);
  if (machine.has_planar_drive()) FillPlanar(*machine.mutable_planar_drive());
  for (AxisDrive& drive : *machine.mutable_axis_drives()) {
    if (drive.has_planar_drive()) FillPlanar(*drive.mutable_planar_drive());
  }
  if (machine.has_laser() && !machine.laser().has_max_missed_in_a_row()) {
    machine.mutable_laser()->set_max_missed_in_a_row(kDefaultMaxMissedInARow);
  }
  FillApertures(machine);
  return machine;
}

}  // namespace intaglio
