#include <cstdint>
#include <string_view>

#include "engrave/contour/files/kicad_read.h"
#include "engrave/core/check.h"

// A board is refused with its file and line, or its elements are within the limits and
// can be rounded, or are refused by that with a sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  intaglio::contour::KicadLimits limits;
  limits.max_elements = 5000;
  const auto board = intaglio::contour::ReadKicadBoard(
      std::string_view(reinterpret_cast<const char*>(bytes), size), "a.kicad_pcb",
      limits);
  if (!board) {
    Require(board.error().message.starts_with("a.kicad_pcb: line "), "no line");
    return 0;
  }
  for (std::uint32_t layer = 0; layer < board->layers.size(); ++layer) {
    const auto rounded =
        intaglio::contour::Rounded(intaglio::contour::ElementsOfLayer(*board, layer));
    Require(rounded || !rounded.error().message.empty(), "an error without a sentence");
  }
  return 0;
}
