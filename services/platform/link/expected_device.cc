#include "services/platform/link/expected_device.h"

#include "services/platform/link/frame.h"

namespace intaglio::link {

std::string ExpectedDevice::VersionHint() const {
  return "the " + kind + " at " + device + " must use version " +
         std::to_string(kFrameVersion) + " of the frames (docs/protocols.md)";
}

std::string RefusalOf(const ExpectedDevice& expected, const std::string& serial_number) {
  if (expected.serial_number.empty() || serial_number == expected.serial_number) {
    return {};
  }
  const std::string answers = serial_number.empty()
                                  ? "a " + expected.kind + " without a serial number"
                                  : expected.kind + " '" + serial_number + "'";
  return "the line at " + expected.device + " leads to " + answers + ", the profile of " +
         expected.cell + " expects '" + expected.serial_number +
         "': swap the cables or correct " + expected.line + ".serial_number";
}

}  // namespace intaglio::link
