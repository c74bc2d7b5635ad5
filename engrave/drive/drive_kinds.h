#pragma once

// The registry of drives: one row per kind. A new kind is a class in a file of its own
// and a row in drive_kinds.cc; the conformance test finds it there.

#include <memory>
#include <span>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/drive/drive.h"

namespace intaglio::drive {

struct DriveParameter {
  std::string_view name;  ///< with its unit, e.g. "lag_s"
  double min = 0, max = 0;
};

struct DriveKind {
  std::string_view name;  ///< e.g. "second_order"
  std::span<const DriveParameter> parameters;
  /// As many values as parameters, each within its range.
  std::shared_ptr<const Drive> (*make)(std::span<const double> values);
};

std::span<const DriveKind> DriveKinds();

/// kNotFound with the known names; kInvalidValue when a value is missing, too many or
/// outside its range.
Result<std::shared_ptr<const Drive>> MakeDrive(std::string_view name,
                                               std::span<const double> values);

}  // namespace intaglio::drive
