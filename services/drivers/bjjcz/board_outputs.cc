#include "services/drivers/bjjcz/board_outputs.h"

namespace intaglio::drivers {

std::uint16_t OutputBits(const BjjczBoard& board, const BoardOutputs& outputs) {
  const auto bit = [](std::uint32_t output, bool on) {
    return static_cast<std::uint16_t>(on ? 1U << output : 0U);
  };
  std::uint16_t bits = bit(board.gate_output(), outputs.permitted && !outputs.in_outline);
  if (board.has_lamp_output()) bits |= bit(board.lamp_output(), outputs.runs);
  if (board.has_guide_output())
    bits |= bit(board.guide_output(), outputs.in_outline && outputs.shows);
  return bits;
}

}  // namespace intaglio::drivers
