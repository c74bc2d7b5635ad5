#pragma once

// A drive that is known by its transfer function alone (transfer.h): the servo, the
// cascade, the stepper with a screw and the planar drive are rows of coefficients
// (loop_kinds.h).

#include <string>

#include "engrave/drive/drive.h"

namespace intaglio::drive {

class LinearDrive final : public Drive {
 public:
  /// Both polynomials begin with 1, the numerator is of lower order, the denominator of
  /// order 1 or above. All zeros of both lie left of the imaginary axis, which is the
  /// caller's promise. Throws PreconditionError.
  LinearDrive(std::string name, const Transfer& transfer);

  std::string_view name() const override { return name_; }
  AxisState Follow(const AxisState& state, const Cubic& command,
                   double duration_s) const override;
  Cubic Settled(const Cubic& command) const override;
  AxisState SettledState(const Cubic& command) const override;
  Transfer transfer() const override { return transfer_; }
  Cubic CommandFor(const Cubic& course) const override;
  double lead_s2() const override;

 private:
  /// A state each, in the drive's own time, see the .cc; the first is the position.
  using States = std::array<Cubic, kMaxOrder>;
  States SettledStates(const Cubic& command) const;

  std::string name_;
  Transfer transfer_;
  std::size_t order_;
  double unit_s_ = 1;  ///< of the drive's own time
  Polynomial a_, b_;   ///< in it; a_[order_] is 1
};

}  // namespace intaglio::drive
