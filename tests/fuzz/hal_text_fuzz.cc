// What LinuxCNC's programs and the files of its folder may hold: never a crash, and never
// a number outside its range.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "services/drivers/linuxcnc/hal_limits.h"
#include "services/drivers/linuxcnc/hal_text.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace intaglio::drivers;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto sample = ParseSample(text.substr(0, text.find('\n')))) {
    if (!sample->actual_mm.allFinite() || !sample->target_mm.allFinite()) std::abort();
    if (sample->row > 1ull << 51 || sample->command > 1ull << 51) std::abort();
  }
  if (const auto identity = ParseIdentity(text)) {
    if (identity->power_up == 0 || identity->period_ns < 50'000) std::abort();
  }
  for (const auto& [pin, value] : ParseHalPins(text)) {
    if (!std::isfinite(value) || pin.size() > size) std::abort();
  }
  if (ParsePulses(text).size() > size / 2) std::abort();
  return 0;
}
