#pragma once

// A device that LightBurn exported: an .lbdev, which is a JSON text, or an .lbzip, a zip
// archive with one in it. Its maker publishes no description. What is read is what public
// programs and files agree on:
//   DeviceList, Name, DisplayName, Width, Height, MirrorX, MirrorY, Settings
//       makerspace/LaserCutting, LightBurn/redsail.lbdev, which LightBurn wrote;
//       earlynerd/glass3D f251878, glass3d/device/lightburn.py; that Name is the driver,
//       JCZFiber of a BJJCZ board: LeeGillie/WeCreat-Lumos-Ultra-LightBurn-Config,
//       docs/10, and srm985/omni-xe-autofocus
//   Galvo_N_Scale, Galvo_1_is_X, Default_JumpSpeed, Laser_MinFreq, Laser_MaxFreq
//       glass3D, as above and glass3d/laser/controller.py; the scale also
//       mirecta/sealaser-galvo 9e8774f, bjjcz/galvo_config.py, from a machine in use: a
//       mm is 65536 / width times the scale in units of the board
// Not public, and so not read: the keys of delays, the formulas of bulge, skew and
// trapezoid, the order of rotation, offset and mirroring.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

/// Of a device alone; of a bundle, which may have libraries of pictures.
inline constexpr std::size_t kMaxLightBurnTextBytes = 1 << 20;
inline constexpr std::size_t kMaxLightBurnFileBytes = 64 << 20;

/// A key and its value, printable, a long one cut.
struct DeviceSetting {
  std::string key, value;
  bool operator==(const DeviceSetting&) const = default;
};

struct LightBurnDevice {
  std::string name;                                  ///< DisplayName, printable
  double width_mm = 0, height_mm = 0;                ///< of the workspace, 1..2000
  double x_scale_ratio = 1, y_scale_ratio = 1;       ///< 0.5..2; 1: none in the file
  std::optional<double> jump_mm_s;                   ///< 10..100000
  std::optional<double> min_pulse_hz, max_pulse_hz;  ///< of the laser, 1 Hz..10 MHz
  /// What changes where a beam goes, and is not read; in alphabetical order.
  std::vector<DeviceSetting> field_not_read;
  /// All others that are not read; in alphabetical order.
  std::vector<DeviceSetting> not_read;
};

/// The device of a BJJCZ board (JCZFiber) with this DisplayName; without a name the only
/// one. `file` begins each error. kUnreadable: neither a JSON text nor a zip archive, or
/// damaged; kTooLarge; kMissing, kInvalidValue: a key, with its place and value;
/// kNotFound: no such device; kUnsupported: none is of a BJJCZ board.
Result<LightBurnDevice> ReadLightBurnDevice(std::string_view bytes,
                                            const std::string& file,
                                            const std::string& name = "");

}  // namespace intaglio
