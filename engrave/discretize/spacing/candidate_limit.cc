#include "engrave/discretize/spacing/candidate_limit.h"

#include <fmt/format.h>

namespace intaglio::discretize {

Status CheckCandidateCount(double count) {
  if (count <= static_cast<double>(kMaxCandidates)) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("the options require at least {:.3g} points, {} are allowed: "
                          "use larger distances or a smaller model",
                          count, kMaxCandidates),
              fmt::format("{:.0f}", count));
}

}  // namespace intaglio::discretize
