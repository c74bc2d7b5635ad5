// Any bytes as a drive profile: refused with a message, or axes that can be sized, tuned
// and simulated.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "services/job/drive/drive_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const auto profile =
      ParseDriveProfile({reinterpret_cast<const char*>(bytes), size}, "fuzz");
  if (!profile) {
    if (profile.error().message.empty()) std::abort();
    return 0;
  }
  constexpr auto kRule = drive::CylinderRule::kSolid;
  const auto phases = DemandOf(*profile);
  for (const DriveAxis& axis : profile->axes()) {
    const auto motor = drive::SizeMotor(ScrewOf(axis), MotorOf(axis), kRule, phases);
    if (!std::isfinite(motor.peak_torque_nm)) std::abort();
    const auto samples = drive::Simulate(SampledAxisOf(*profile, axis, kRule),
                                         std::vector<double>{0, 0.001, 0.001, 0.001});
    if (!samples && samples.error().message.empty()) std::abort();
  }
  return 0;
}
