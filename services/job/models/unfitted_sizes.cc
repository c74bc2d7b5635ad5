#include "services/job/models/unfitted_sizes.h"

#include <filesystem>
#include <system_error>

#include "engrave/core/try.h"
#include "engrave/mesh/plausible_size.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"
#include "services/job/models/model_sources.h"

namespace intaglio {
namespace {

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{64} << 20;

bool IsUnfitted(const Model& model) {
  const auto kind = KindOf(model);
  if (kind != ModelKind::kMesh && kind != ModelKind::kDrawing) return false;
  if (model.placement().fit_case() != Placement::FIT_NOT_SET) return false;
  std::error_code error;
  const auto bytes = std::filesystem::file_size(model.file(), error);
  return !error && bytes <= kMaxBytes;
}

}  // namespace

Status CheckUnfittedSizes(const JobSpec& job, const ReadLimits& limits) {
  JobSpec unfitted = job;
  unfitted.clear_models();
  for (const Model& model : job.models()) {
    if (!IsUnfitted(model)) continue;
    *unfitted.add_models() = model;
    unfitted.mutable_models()->rbegin()->clear_copies();
  }
  if (unfitted.models().empty()) return {};
  const auto sizes = INTAGLIO_TRY(SizesOf(unfitted, limits));
  for (int i = 0; i < unfitted.models_size(); ++i) {
    const Model& model = unfitted.models(i);
    const ModelSize& size = sizes.at(static_cast<std::size_t>(i));
    const auto fault =
        mesh::FindSizeFault({.size_mm = size.size_mm,
                             .block_size_mm = Vec3Of(BlockOf(job, model).size_mm()),
                             .unit_mm = size.unit_mm,
                             .clip = job.block().clip(),
                             .min_spacing_mm = job.discretization().min_spacing_mm()},
                            model.file());
    if (fault && fault->refused) {
      return Fail(ErrorCode::kOutsideBlock, fault->warning.text);
    }
  }
  return {};
}

}  // namespace intaglio
