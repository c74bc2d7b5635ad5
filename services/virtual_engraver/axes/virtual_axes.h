#pragma once

// The axes of the virtual engraver: mechanics that lag, and what no encoder sees of them.

#include <optional>

#include "services/virtual_engraver/axes/stage_axes.h"
#include "services/virtual_engraver/mechanics/backlash.h"
#include "services/virtual_engraver/mechanics/repeatability.h"
#include "services/virtual_engraver/mechanics/vibration.h"

namespace intaglio::virtual_engraver {

struct VirtualAxesOptions {
  MechanicsOptions mechanics;  ///< of each axis
  std::optional<VibrationOptions> vibration = {};
  Vec3 backlash_mm = Vec3::Zero();  ///< of each axis, >= 0
  double repeatability_mm = 0;      ///< of every place they go to, each axis
  unsigned repeatability_seed = 0;
};

class VirtualAxes final : public StageAxes {
 public:
  VirtualAxes(const VirtualAxesOptions& options, const Vec3& at_mm);

  void Follow(const CubicCommand& command, double from_s, double to_s) override;
  const Vec3& actual_mm() const override { return mechanics_.actual_mm(); }
  Vec3 velocity_lag_s() const override { return mechanics_.velocity_lag_s(); }
  std::optional<Vec3> expected_mm() const override;
  const Mechanics* mechanics() const override { return &mechanics_; }
  Vec3 BesideMm(double done_ratio) const override;
  void PassEnd() override { repeatability_.PassEnd(); }
  void LeaveAt(double done_ratio) override { repeatability_.LeaveAt(done_ratio); }
  void Stick(int axis) override { mechanics_.Stick(axis); }
  void Unstick() override { mechanics_.Unstick(); }

 private:
  Mechanics mechanics_;
  // The controller's model of its loops: where the axes are to be.
  std::optional<Mechanics> expected_;
  Backlash backlash_;
  std::optional<Vibration> vibration_;
  Repeatability repeatability_;
};

}  // namespace intaglio::virtual_engraver
