#pragma once

// Finds the driver that a line of the machine profile names in the table of a seam
// (services/drivers/interface/motion_driver.h,
// services/drivers/interface/laser_controller.h).

#include <fmt/format.h>

#include <span>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/link/endpoint.h"

namespace intaglio::link {

/// A line of the profile; SerialLine of proto/machine.proto.
struct NamedLine {
  std::string field;     ///< "laser_line" or "motion_line"
  std::string protocol;  ///< name of the driver
  std::string device;
};

/// Kind: has a member `protocol` (std::string_view) and a member `needs_device` (bool: it
/// opens the line's device by endpoint.h). kUnsupported for a protocol that no kind has,
/// with those that there are; kMissing and kInvalidValue for a device that is needed and
/// missing or of no known form. Each names the field.
template <typename Kind>
Result<const Kind*> FindDriver(std::span<const Kind> kinds, const NamedLine& line) {
  const Kind* found = nullptr;
  std::string known;
  for (const Kind& kind : kinds) {
    if (kind.protocol == line.protocol) found = &kind;
    known += (known.empty() ? "" : ", ") + std::string(kind.protocol);
  }
  if (found == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{}.protocol: no driver for '{}'; there are: {}", line.field,
                            line.protocol, known),
                line.protocol);
  }
  if (!found->needs_device) return found;
  if (line.device.empty()) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{}.device: is missing; give what the driver '{}' opens, in "
                            "the profile or by --device",
                            line.field, line.protocol));
  }
  if (auto good = CheckDevice(line.device); !good) {
    return Fail(good.error().code,
                fmt::format("{}.device: {}", line.field, good.error().message),
                line.device);
  }
  return found;
}

}  // namespace intaglio::link
