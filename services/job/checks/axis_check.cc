#include "services/job/checks/axis_check.h"

#include <fmt/format.h>

#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

void CheckTravel(const std::string& path, const char* unit, double min, double max,
                 std::vector<Error>& errors) {
  if (min < max) return;
  errors.push_back(
      {ErrorCode::kInvalidValue,
       fmt::format("{0}.travel_min_{1}: {2} is not below {0}.travel_max_{1}, "
                   "{3}",
                   path, unit, min, max),
       fmt::format("{}", min)});
}

}  // namespace

void CheckAxis(bool present, const AxisLimits& axis, const std::string& path,
               std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  CheckTravel(path, "mm", axis.travel_min_mm(), axis.travel_max_mm(), errors);
}

void CheckAxis(bool present, const RotaryAxis& axis, const std::string& path,
               std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  CheckTravel(path, "rad", axis.travel_min_rad(), axis.travel_max_rad(), errors);
}

}  // namespace intaglio
