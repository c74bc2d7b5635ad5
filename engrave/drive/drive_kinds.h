#pragma once

// The registry of drives: one row per kind. A new kind is a class in a file of its own
// and a row in drive_kinds.cc; the conformance test finds it there.

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/drive.h"

namespace intaglio::drive {

struct DriveParameter {
  std::string_view name;  ///< with its unit, e.g. "lag_s"
  double min = 0, max = 0;
};

/// Factors on the natural frequencies and on the damping ratios of a drive.
struct MechanicsRatios {
  double frequency = 1;
  double damping = 1;
};

struct DriveKind {
  std::string_view name;  ///< e.g. "second_order"
  std::span<const DriveParameter> parameters;
  /// As many values as parameters, each within its range.
  std::shared_ptr<const Drive> (*make)(std::span<const double> values);
  /// The values of the same drive with other mechanics. A lag is 1 / frequency; a servo
  /// is of second order, by its gain and its time; of a cascade it is the mechanics
  /// alone.
  void (*vary)(std::span<double> values, const MechanicsRatios& ratios);
  /// What the ranges do not say; null: nothing.
  Status (*check)(std::span<const double> values) = nullptr;
};

std::span<const DriveKind> DriveKinds();

/// A drive by its kind's name and its values.
struct DriveParameters {
  std::string_view name;
  std::vector<double> values;
};

/// How far a controller's period stays below the one at which its loop begins to swing,
/// so that it is also stable with mechanics that are 20 % off.
inline constexpr double kStabilityReserveRatio = 1.25;

/// kNotFound with the known names; kInvalidValue when a value is missing, too many or
/// outside its range, or when the loop is not stable with the reserve: then with the
/// longest period that is.
Result<std::shared_ptr<const Drive>> MakeDrive(std::string_view name,
                                               std::span<const double> values);

/// The same drive with other mechanics; values that leave their ranges get their ends.
/// A drive that
/// MakeDrive makes stays stable up to 5 % in frequency or 20 % in damping. Errors: those
/// of MakeDrive but the stability's.
Result<std::shared_ptr<const Drive>> MakeDriveWith(const MechanicsRatios& ratios,
                                                   const DriveParameters& drive);

}  // namespace intaglio::drive
