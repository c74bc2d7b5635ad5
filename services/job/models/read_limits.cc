#include "services/job/models/read_limits.h"

#include <fmt/format.h>

#include "engrave/core/check.h"

namespace intaglio {

ReadLimits ReadLimitsTimes(double factor) {
  Require(factor >= kMinSizeLimits && factor <= kGreatestSizeLimits,
          "the factor of size limits must be {}..{}, is {}", kMinSizeLimits,
          kGreatestSizeLimits, factor);
  ReadLimits limits;
  limits.factor = factor;
  for (std::uint64_t* limit :
       {&limits.max_file_bytes, &limits.meshes.max_file_bytes,
        &limits.meshes.max_triangles, &limits.drawings.max_file_bytes,
        &limits.drawings.max_entities, &limits.drawings.max_points,
        &limits.drawings.max_unfolded_bytes, &limits.images.max_file_bytes,
        &limits.images.max_pixels, &limits.images.max_decoder_bytes,
        &limits.points.max_file_bytes, &limits.points.max_points}) {
    *limit = static_cast<std::uint64_t>(static_cast<double>(*limit) * factor);
  }
  return limits;
}

Error WithRemedy(Error error, const ReadLimits& limits) {
  if (error.code != ErrorCode::kTooLarge) return error;
  error.message += fmt::format(" (--size-limits FACTOR or {}, now {:g})",
                               kSizeLimitsVariable, limits.factor);
  return error;
}

}  // namespace intaglio
