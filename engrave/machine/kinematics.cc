#include "engrave/machine/kinematics.h"

#include <cmath>

#include "engrave/machine/cartesian.h"
#include "engrave/machine/polar.h"
#include "engrave/machine/scan_head.h"

namespace intaglio::machine {

std::array<KinematicsKind, std::variant_size_v<KinematicsOptions>> KinematicsKinds() {
  return {{{"cartesian",
            [](const KinematicsOptions& options) {
              return MakeCartesian(std::get<CartesianOptions>(options));
            }},
           {"polar",
            [](const KinematicsOptions& options) {
              return MakePolar(std::get<PolarOptions>(options));
            }},
           {"head_over_block", [](const KinematicsOptions& options) {
              return MakeScanHead(std::get<ScanHeadOptions>(options));
            }}}};
}

std::shared_ptr<const Kinematics> MakeKinematics(const KinematicsOptions& options) {
  return KinematicsKinds()[options.index()].make(options);
}

Vec3 BranchStart(const Box3& travel) {
  Vec3 start = travel.center_mm();
  for (double& coordinate : start) {
    if (!std::isfinite(coordinate)) coordinate = 0;
  }
  return start;
}

}  // namespace intaglio::machine
