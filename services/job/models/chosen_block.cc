#include "services/job/models/chosen_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"
#include "engrave/mesh/plausible_size.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/model_sources.h"

namespace intaglio {
namespace {

// A block chosen for the user: this much glass around the object, in whole steps.
constexpr double kChosenMarginMm = 5;
constexpr double kBlockStepMm = 5;
// The size of an object does not depend on its block.
constexpr double kAnyBlockMm = 1000;
constexpr double kUsualRoomMm = 200;

Vector3 VectorOf(const Vec3& v) {
  Vector3 vector;
  vector.set_x(v.x());
  vector.set_y(v.y());
  vector.set_z(v.z());
  return vector;
}

/// The block that an object of this size gets: with a margin, in whole steps.
Vector3 BlockFor(const Vec3& size_mm) {
  const auto side = [](double extent) {
    return std::max(
        2 * kChosenMarginMm,
        std::ceil((extent + 2 * kChosenMarginMm) / kBlockStepMm) * kBlockStepMm);
  };
  return VectorOf({side(size_mm.x()), side(size_mm.y()), side(size_mm.z())});
}

/// About the largest block of the machine: with the focus in the glass z takes a third
/// more than its travel. Of axes that turn, a usual size.
Vec3 LargestBlockOf(const MachineSpec& machine) {
  if (machine.has_polar()) return Vec3::Constant(kUsualRoomMm);
  const auto travel_mm = [](const AxisLimits& axis) {
    return std::max(1.0, axis.travel_max_mm() - axis.travel_min_mm());
  };
  return {travel_mm(machine.x()), travel_mm(machine.y()), 1.5 * travel_mm(machine.z())};
}

/// Judges meshes and drawings, whose files have a unit that may be forgotten: an error,
/// or notes for the user.
Status CheckSizes(const JobSpec& job, const MachineSpec& machine,
                  const std::vector<ModelSize>& sizes, std::vector<std::string>& notes) {
  const std::string room = "the largest block of " + machine.name();
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    const auto kind = KindOf(model);
    if (kind != ModelKind::kMesh && kind != ModelKind::kDrawing) continue;
    mesh::SizeInBlock sized;
    sized.size_mm = sizes.at(static_cast<std::size_t>(i)).size_mm;
    sized.block_size_mm = LargestBlockOf(machine);
    sized.unit_mm = sizes.at(static_cast<std::size_t>(i)).unit_mm;
    sized.fitted = model.placement().fit_case() != Placement::FIT_NOT_SET;
    sized.clip = job.block().clip();
    sized.min_spacing_mm = job.discretization().min_spacing_mm();
    sized.room = room;
    const auto fault = mesh::FindSizeFault(sized, model.file());
    if (!fault) continue;
    if (fault->refused) return Fail(ErrorCode::kOutsideBlock, fault->warning.text);
    notes.push_back(fault->warning.text);
  }
  return {};
}

}  // namespace

Status ChooseBlock(JobSpec& job, const MachineSpec& machine, const ReadLimits& limits,
                   std::vector<std::string>& notes) {
  JobSpec complete = job;
  *complete.mutable_block()->mutable_size_mm() = VectorOf(Vec3::Constant(kAnyBlockMm));
  complete = WithDefaults(std::move(complete), machine);
  for (const Model& model : complete.models()) {
    if (!model.placement().has_fit_block()) continue;
    return Fail(
        ErrorCode::kMissing,
        model.file() + " has to fill the block: give the size of the block with --block");
  }
  const auto sizes = INTAGLIO_TRY(SizesOf(complete, limits));
  INTAGLIO_TRY(CheckSizes(complete, machine, sizes, notes));
  Vec3 size = Vec3::Zero();
  for (int i = 0; i < complete.models_size(); ++i) {
    const ModelSize& one = sizes.at(static_cast<std::size_t>(i));
    size = size.cwiseMax(one.size_mm);
    if (one.box_mm.empty() || !complete.models(i).placement().centre_in_block()) continue;
    // A model that is moved from the centre needs as much on the other side.
    const Vec3 middle = Vec3::Constant(kAnyBlockMm / 2);
    size = size.cwiseMax(2 * (one.box_mm.max_mm - middle))
               .cwiseMax(2 * (middle - one.box_mm.min_mm));
  }
  const Vector3 block = BlockFor(size);
  *job.mutable_block()->mutable_size_mm() = block;
  notes.push_back(fmt::format(
      "block {:g} x {:g} x {:g} mm, chosen to fit the object ({:.1f} x {:.1f} x {:.1f} "
      "mm); use --block X Y Z for another size",
      block.x(), block.y(), block.z(), size.x(), size.y(), size.z()));
  return {};
}

Vector3 BlockAround(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  if (box.empty()) return BlockFor(Vec3::Zero());
  const Vec3 to_far_side_mm = box.max_mm - Vec3::Constant(kChosenMarginMm);
  return BlockFor(box.size_mm().cwiseMax(to_far_side_mm));
}

}  // namespace intaglio
