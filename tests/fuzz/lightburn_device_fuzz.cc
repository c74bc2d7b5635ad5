// Any bytes as a device of LightBurn: refused with the file's name and a remedy, or a
// device within its ranges whose settings are printable, and which a profile takes.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "engrave/core/check.h"
#include "services/job/files/lightburn_device.h"
#include "services/job/files/lightburn_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto printable = [](const std::string& shown) {
    return std::ranges::all_of(shown, [](char c) { return c >= ' ' && c <= '~'; });
  };
  for (const char* name : {"", "UV 110"}) {
    const auto device = intaglio::ReadLightBurnDevice(text, "a.lbdev", name);
    if (!device) {
      Require(device.error().message.starts_with("a.lbdev: "),
              "an error without the file");
      continue;
    }
    for (const auto* settings : {&device->field_not_read, &device->not_read}) {
      for (const auto& setting : *settings)
        Require(printable(setting.key + setting.value), "a setting is not printable");
    }
    intaglio::MachineSpec machine;
    machine.mutable_scan_head();
    machine.mutable_bjjcz_board()->set_point_frequency_hz(30000);
    machine.mutable_head_over_block()->mutable_jump_and_dwell();
    if (!intaglio::ApplyDevice(*device, machine)) continue;
    const double field_mm = machine.scan_head().field_mm();
    Require(field_mm >= 0.5 && field_mm <= 4000, "a field that no device has");
    Require(std::isfinite(machine.bjjcz_board().point_frequency_hz()), "no frequency");
  }
  return 0;
}
