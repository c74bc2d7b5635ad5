// Any bytes as a board file: refused with a message, or a board that a controller can be
// made of, whose lines all differ.

#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "services/reference_controller/board_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::reference_controller;
  const auto board = ParseBoard({reinterpret_cast<const char*>(bytes), size}, "fuzz");
  if (!board) {
    if (board.error().message.empty()) std::abort();
    return 0;
  }
  std::set<std::pair<std::string, std::uint32_t>> lines;
  for (const NamedLine& named : BoardLines(*board))
    if (!lines.emplace(named.line.chip(), named.line.line()).second) std::abort();
  const ControllerOptions options = OptionsOf(*board, 1);
  if (options.laser.channels < 1 || options.laser.channels > 4) std::abort();
  if (options.laser.rates_hz.empty() || options.sensor_window.count() <= 0) std::abort();
  return 0;
}
