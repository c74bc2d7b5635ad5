#pragma once

// From a point of the glass to the axes, and back: the focus depth of the optics and the
// kinematics of the machine, one after the other.

#include <memory>

#include "engrave/machine/kinematics.h"
#include "engrave/optics/machine_frame.h"

namespace intaglio::machine {

/// A value; copies share the kinematics, which is constant. Default: the glass is air, at
/// the machine's zero, under three linear axes that move the head.
class AxesFromGlass {
 public:
  AxesFromGlass() : AxesFromGlass({}, MakeKinematics(CartesianOptions{})) {}
  /// `kinematics` is not null.
  AxesFromGlass(const optics::MachineFromGlass& machine_from_glass,
                std::shared_ptr<const Kinematics> kinematics)
      : machine_from_glass_(machine_from_glass), kinematics_(std::move(kinematics)) {}

  /// Errors and `near` are those of Kinematics::ToAxes.
  Result<Vec3> ToAxes(const Vec3& glass_mm, const Vec3& near) const {
    return kinematics_->ToAxes(machine_from_glass_.ToMachine(glass_mm), near);
  }
  Vec3 ToGlass(const Vec3& axes) const {
    return machine_from_glass_.ToGlass(kinematics_->ToPlace(axes));
  }
  const optics::MachineFromGlass& machine_from_glass() const {
    return machine_from_glass_;
  }
  const Kinematics& kinematics() const { return *kinematics_; }

 private:
  optics::MachineFromGlass machine_from_glass_;
  std::shared_ptr<const Kinematics> kinematics_;
};

/// The coordinates that the axes need for the places of a box of the glass, mm, from a
/// grid over it that has its corners: exact where axes are linear, else within a
/// thousandth of the box or so. `travel` decides with which turn it begins. Errors are
/// those of ToAxes for a place of the grid.
Result<Box3> AxesOver(const AxesFromGlass& axes_from_glass, const Box3& glass_mm,
                      const Box3& travel);

/// The axes at each point of a path, each near the one before, the first near the middle
/// of `travel`. Errors are those of ToAxes, for the first point that fails.
Result<PointList> AxesAlong(const AxesFromGlass& axes_from_glass, PointList glass_mm,
                            const Box3& travel);

}  // namespace intaglio::machine
