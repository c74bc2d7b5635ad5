#pragma once

// The LinuxCNC driver with LinuxCNC itself, in real time: a step is a millisecond or
// more. A tap between driver and HAL sees every sample, and cuts the line.

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "services/drivers/linuxcnc/hal_line.h"
#include "services/drivers/linuxcnc/hal_text.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/services/drivers/motion_rig.h"

namespace intaglio::linuxcnc {

class HalTap {
 public:
  /// A line for the driver; the same programs of HAL go on when it is not lost.
  drivers::HalOpener Opener();
  /// Takes what HAL has reported.
  void Pump();
  /// HAL has started, or ends.
  void Plug();
  void Unplug() { line_.reset(); }
  void Cut(bool cut);
  void CutAfter(std::uint64_t bytes) { bytes_left_ = bytes; }
  const drivers::HalSample& newest() const { return newest_; }
  bool moves() const { return still_samples_ < 20; }

 private:
  class Handle;
  bool cut() const { return bytes_left_ == std::uint64_t{0}; }
  std::string_view Pass(std::string_view text);

  std::unique_ptr<drivers::HalLine> line_;
  std::optional<std::uint64_t> bytes_left_;  // until the cut; nullopt: there is none
  std::string to_driver_, partial_;
  drivers::HalSample newest_;
  int still_samples_ = 1000;
};

/// A rig of this machine, in a folder of the test's own; null when HAL cannot run here.
std::unique_ptr<drivers::MotionRig> MakeMotionRig(const std::string& serial_number = "");
std::unique_ptr<drivers::LaserRig> MakeLaserRig(const std::string& serial_number = "");

}  // namespace intaglio::linuxcnc
