#include "services/job/convert/job_defaults.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "engrave/io/lower_case.h"
#include "engrave/mesh/up_convention.h"
#include "engrave/optics/pulse_focus.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/convert/placeholders.h"
#include "services/job/convert/rows.h"
#include "services/job/fields/job_kind.h"
#include "services/job/head/point_pulses.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_defaults.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

constexpr double kThinnestSlabMm = 0.01;  // of SweepOrder
/// Of the tolerance in depth: with all of it the places from which z reaches two slabs
/// have one point alone, and the mirrors wait for z at it.
constexpr double kSlabPerTolerance = 0.85;

std::string NameOf(const Model& model) {
  return IsText(model)      ? WithoutBraces(NumberedText(model.text().text(), 1))
         : model.has_code() ? WithoutBraces(NumberedText(model.code().text(), 1))
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
  if (extension == "dae") return UP_AXIS_DECLARED;
  // Nobody has answered where a person has to be asked (model_checks.h).
  return mesh::UpConventionOf(extension) == mesh::UpConvention::kZ ? UP_AXIS_Z
                                                                   : UP_AXIS_DECLARED;
}

void FillPlacement(const Model& model, Placement& placement) {
  if (!MayDeclareUnit(model)) FillDefaults(placement, {Placement::kUnitMmFieldNumber});
  FillDefaults(placement,
               {Placement::kScaleRatioFieldNumber, Placement::kRotateDegFieldNumber,
                Placement::kMoveMmFieldNumber, Placement::kCentreInBlockFieldNumber});
}

/// The method of a Model or a Discretization; nothing when it has none.
void FillChosen(google::protobuf::Message& holder, double spacing_mm) {
  const Method* method = MethodOf(holder);
  if (method == nullptr) return;
  FillDefaults(MutableMessageOf(*method, holder), {"min_spacing_mm", spacing_mm});
}

/// The method of meshes that name none.
void FillDiscretization(Discretization& discretization) {
  FillDefaults(discretization);
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
  if (IsText(model)) FillDefaults(*model.mutable_text());
  if (model.has_copies()) FillDefaults(*model.mutable_copies());
  if (model.has_code()) FillDefaults(*model.mutable_code());
  if (model.method_case() == Model::METHOD_NOT_SET) ChooseMethod(model, discretization);
  FillChosen(model, discretization.min_spacing_mm());
}

/// The job has its other defaults.
void FillOrdering(JobSpec& job, const MachineSpec& machine) {
  Ordering& ordering = *job.mutable_ordering();
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
    ordering.mutable_sweep()->set_slab_mm(std::max(
        kThinnestSlabMm, kSlabPerTolerance * 1e-3 * job.motion().depth_tolerance_um()));
  }
  if (ordering.has_layers() && !ordering.layers().has_layer_thickness_mm()) {
    ordering.mutable_layers()->set_layer_thickness_mm(
        job.discretization().min_spacing_mm());
  }
  if (ordering.has_anneal()) {
    FillDefaults(*ordering.mutable_anneal());
  }
  if (ordering.has_boustrophedon()) FillRows(*ordering.mutable_boustrophedon(), job);
  if (ordering.has_published_kdz()) {
    PublishedKdzOrder& published = *ordering.mutable_published_kdz();
    if (published.has_angle_deg()) return;
    FillDefaults(published);
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
  FillDefaults(motion);
  if (!motion.has_depth_tolerance_um()) {
    motion.set_depth_tolerance_um(DefaultDepthToleranceUm(lens, machine));
  }
  if (motion.has_lq()) FillDefaults(*motion.mutable_lq());
}

void FillLaser(LaserOptions& laser, const MachineSpec& given) {
  const MachineSpec machine = ForWavelengthOf(laser, given);
  const LaserHead& head = machine.laser();
  if (!laser.has_rate_hz() && head.rates_hz_size() > 0)
    laser.set_rate_hz(DefaultRateHz(head));
  if (!laser.has_wavelength_nm()) laser.set_wavelength_nm(head.wavelength_nm());
  if (!laser.has_pulse_energy_mj()) laser.set_pulse_energy_mj(head.pulse_energy_mj());
  if (!laser.has_pulses_per_point() && machine.head_over_block().has_jump_and_dwell())
    laser.set_pulses_per_point(PulsesOfDwell(machine));
  FillDefaults(laser);
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

}  // namespace

JobSpec WithDefaults(JobSpec job, const MachineSpec& machine) {
  if (MakesMarks(job)) return WithMarkDefaults(std::move(job));
  if (job.name().empty() && job.models_size() > 0) job.set_name(NameOf(job.models(0)));
  FillDefaults(*job.mutable_block(), {Block::kMarginMmFieldNumber});
  FillLens(*job.mutable_lens(), machine);
  FillSpacing(job.lens(), machine, *job.mutable_discretization());
  FillDiscretization(*job.mutable_discretization());
  for (Model& model : *job.mutable_models()) FillModel(model, job.discretization());
  FillMotion(*job.mutable_motion(), job.lens(), machine);
  FillOrdering(job, machine);
  FillLaser(*job.mutable_laser(), machine);
  FillChannels(job);
  if (machine.has_loading() && !job.has_station()) job.set_station(1);
  return job;
}

}  // namespace intaglio
