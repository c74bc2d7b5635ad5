// Any bytes as a board file of a stage: refused with a message, or a board that a
// controller can be made of, whose lines all differ and whose axes are no faster than
// their steps.

#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "services/reference_controller/stage_board.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::reference_controller;
  const auto board =
      ParseStageBoard({reinterpret_cast<const char*>(bytes), size}, "fuzz");
  if (!board) {
    if (board.error().message.empty()) std::abort();
    return 0;
  }
  std::set<std::pair<std::string, std::uint32_t>> lines;
  for (const NamedLine& named : BoardLines(*board))
    if (!lines.emplace(named.line.chip(), named.line.line()).second) std::abort();
  const StageControllerOptions options = OptionsOf(*board, 1);
  for (int axis = 0; axis < 3; ++axis) {
    const double rate_hz =
        options.stage.max_speed_mm_s[axis] * options.steps.steps_per_mm[axis];
    if (!(rate_hz <= options.steps.max_rate_hz)) std::abort();
    if (!(options.stage.travel_min_mm[axis] < options.stage.travel_max_mm[axis]))
      std::abort();
    if (!(options.stage.homing->axes[static_cast<std::size_t>(axis)].search_mm > 0))
      std::abort();
  }
  if (options.steps.pulse.count() <= 0) std::abort();
  return 0;
}
