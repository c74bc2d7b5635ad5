#include "services/job/models/arrangement.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/counted.h"
#include "engrave/core/geometry.h"
#include "engrave/core/try.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/model_sources.h"

// Boxes are measured in a cube of glass and moved from its centre, where models lie that
// have no place of their own; so a move is one of the placement.

namespace intaglio {
namespace {

constexpr double kCubeMm = 1000;

bool IsCloud(const Model& model) {
  const auto kind = KindOf(model);
  return kind && *kind == ModelKind::kCloud;
}

bool HasOwnPlace(const Model& model) {
  const Placement& placement = model.placement();
  return placement.has_move_mm() || placement.has_fit_block() ||
         placement.has_centre_in_block() || IsCloud(model);
}

bool IsMovable(const Model& model) {
  const Placement& placement = model.placement();
  const bool centred =
      placement.has_centre_in_block() ? placement.centre_in_block() : !IsCloud(model);
  return centred && !placement.has_fit_block();
}

/// From the centre of the block, before it is turned.
Result<std::vector<Box3>> BoxesOf(const JobSpec& job, const MachineSpec& machine,
                                  const ReadLimits& limits) {
  JobSpec complete = job;
  Block& block = *complete.mutable_block();
  block.clear_quarter_turns();
  block.mutable_size_mm()->set_x(kCubeMm);
  block.mutable_size_mm()->set_y(kCubeMm);
  block.mutable_size_mm()->set_z(kCubeMm);
  complete = WithDefaults(std::move(complete), machine);
  std::vector<Box3> boxes;
  for (const ModelSize& one : INTAGLIO_TRY(SizesOf(complete, limits))) {
    Box3 box = one.box_mm;
    if (box.empty()) box = {Vec3::Constant(kCubeMm / 2), Vec3::Constant(kCubeMm / 2)};
    box.min_mm.array() -= kCubeMm / 2;
    box.max_mm.array() -= kCubeMm / 2;
    boxes.push_back(box);
  }
  return boxes;
}

void Shift(const Vec3& by_mm, Box3& box) {
  box.min_mm += by_mm;
  box.max_mm += by_mm;
}

/// A row along x, each in the middle of y and z.
void PutSideBySide(const std::vector<Box3*>& boxes) {
  double x_mm = 0;
  for (Box3* box : boxes) {
    Shift(-box->center_mm(), *box);
    Shift({x_mm - box->min_mm.x(), 0, 0}, *box);
    x_mm = box->max_mm.x() + kArrangedGapMm;
  }
}

/// In which direction the text lies of the models; zero: in their centre.
Vec3 DirectionOf(std::string_view place) {
  if (place == "below") return {0, 0, -1};
  if (place == "above") return {0, 0, 1};
  if (place == "left") return {-1, 0, 0};
  if (place == "right") return {1, 0, 0};
  if (place == "front") return {0, -1, 0};
  if (place == "behind") return {0, 1, 0};
  return Vec3::Zero();
}

void PutBeside(const Box3& models, const Vec3& direction, Box3& text) {
  const Vec3 half_mm = 0.5 * (models.size_mm() + text.size_mm());
  const Vec3 distance_mm = half_mm + Vec3::Constant(kArrangedGapMm);
  Shift(models.center_mm() - text.center_mm() + direction.cwiseProduct(distance_mm),
        text);
}

/// A flat one is as thick as its points are apart.
Box3 Thickened(Box3 box, double min_mm) {
  const Vec3 half_mm = 0.5 * box.size_mm().cwiseMax(min_mm);
  const Vec3 center_mm = box.center_mm();
  return {center_mm - half_mm, center_mm + half_mm};
}

double OverlapMm3(const Box3& a, const Box3& b) {
  const Box3 both{a.min_mm.cwiseMax(b.min_mm), a.max_mm.cwiseMin(b.max_mm)};
  return both.empty() ? 0 : both.size_mm().prod();
}

Status CheckTextPlace(const JobSpec& job, const std::string& place) {
  const auto texts = std::count_if(job.models().begin(), job.models().end(), IsText);
  if (texts != 1) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--text-place {}: the job has {}, and one can be placed; "
                            "give the others models[].placement.move_mm",
                            place, Counted(static_cast<std::uint64_t>(texts), "text")),
                place);
  }
  for (const Model& model : job.models()) {
    if (IsMovable(model) && job.channel_blocks().empty()) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("--text-place {}: {} fills the block, is not centred in it, or has a "
                    "block of its channel; move the text with models[].placement.move_mm",
                    place, model.file()),
        place);
  }
  return {};
}

void Move(const Vec3& by_mm, Model& model) {
  Vector3& move = *model.mutable_placement()->mutable_move_mm();
  move.set_x(move.x() + by_mm.x());
  move.set_y(move.y() + by_mm.y());
  move.set_z(move.z() + by_mm.z());
}

void NoteOverlap(const Box3& text, const std::vector<Box3*>& others, double spacing_mm,
                 Warnings& warnings) {
  double overlap_mm3 = 0;
  for (const Box3* other : others) {
    overlap_mm3 += OverlapMm3(Thickened(text, spacing_mm), Thickened(*other, spacing_mm));
  }
  if (overlap_mm3 <= 0) return;
  warnings.push_back(MakeWarning(
      WarningCode::kModelsOverlap,
      fmt::format("the text and the models overlap in a volume of {:.1f} mm3 (of "
                  "the boxes around them); --text-place below keeps them apart",
                  overlap_mm3)));
}

}  // namespace

bool IsFreeToArrange(const JobSpec& job) {
  return job.models_size() > 1 && job.channel_blocks().empty() &&
         std::none_of(job.models().begin(), job.models().end(), HasOwnPlace);
}

Status Arrange(const std::optional<std::string>& text_place, const MachineSpec& machine,
               const ReadLimits& limits, JobSpec& job, Warnings& warnings) {
  if (text_place) INTAGLIO_TRY(CheckTextPlace(job, *text_place));
  const bool is_free = IsFreeToArrange(job);
  std::vector<Box3> boxes = INTAGLIO_TRY(BoxesOf(job, machine, limits));
  const std::vector<Box3> before = boxes;
  std::vector<Box3*> others;
  Box3* text = nullptr;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (IsText(job.models(static_cast<int>(i))) && text == nullptr) {
      text = &boxes[i];
    } else {
      others.push_back(&boxes[i]);
    }
  }
  if (is_free) PutSideBySide(others);
  Box3 all;
  for (const Box3* other : others) all.Extend(*other);
  if (text != nullptr && !others.empty()) {
    PutBeside(all, DirectionOf(text_place.value_or("below")), *text);
    NoteOverlap(*text, others, job.discretization().min_spacing_mm(), warnings);
    all.Extend(*text);
  }
  const Vec3 to_centre_mm = is_free ? Vec3(-all.center_mm()) : Vec3(Vec3::Zero());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Vec3 by_mm = boxes[i].center_mm() - before[i].center_mm() + to_centre_mm;
    if (!by_mm.isZero(1e-9)) Move(by_mm, *job.mutable_models(static_cast<int>(i)));
  }
  return {};
}

}  // namespace intaglio
