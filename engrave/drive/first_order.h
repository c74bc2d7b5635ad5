#pragma once

// An axis that lags behind its command: x' = (c - x) / lag. It passes a point at speed v
// a distance lag v late: 16 um at 80 mm/s and 0.2 ms. With the command c = p + lag p' it
// follows the course p.

#include "engrave/drive/drive.h"

namespace intaglio::drive {

inline constexpr double kMaxLagS = 0.1;

class FirstOrder final : public Drive {
 public:
  /// 0..kMaxLagS; 0: the axis is where it is commanded. Throws PreconditionError.
  explicit FirstOrder(double lag_s);

  std::string_view name() const override { return "first_order"; }
  AxisState Follow(const AxisState& state, const Cubic& command,
                   double duration_s) const override;
  Cubic Settled(const Cubic& command) const override;
  AxisState SettledState(const Cubic& command) const override;
  Transfer transfer() const override { return {{1}, {1, lag_s_}}; }
  Cubic CommandFor(const Cubic& course) const override;
  double lead_s2() const override { return 0.5 * lag_s_ * lag_s_; }

 private:
  double lag_s_;
};

}  // namespace intaglio::drive
