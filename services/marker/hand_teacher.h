#pragma once

// The axes of a machine that follows contours, as a person moves them by hand. Nothing is
// saved here: the work zero is the controller's.

#include "proto/machine.pb.h"
#include "services/cell/manual/teacher.h"

namespace intaglio::marker {

class HandTeacher final : public cell::Teacher {
 public:
  /// The profile of such a machine has no travel: as far from the work zero as any such
  /// machine goes. Its own limits are the controller's ($20, $130..$132).
  static constexpr double kReach_mm = 3000;

  cell::TaughtAxes axes() const override;
  std::uint32_t channel_count() const override { return 0; }
  bool zero_is_in_controller() const override { return true; }
  Result<Vec3> AxesAtZero(const intaglio_ManualCommand& command,
                          const Vec3& position) const override;
  Result<std::string> Save(const intaglio_ManualCommand& command,
                           const Vec3& position) override;
};

}  // namespace intaglio::marker
