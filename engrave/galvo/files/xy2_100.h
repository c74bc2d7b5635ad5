#pragma once

// XY2-100, the serial line from a control board to a scan head: frames of 20 bits at 2
// MHz, 10 us each; the head reads at the falling edge of the clock; SYNC is low in the
// last bit. A frame is 001, the position in 16 bits, most significant first, 32768 in the
// centre, and a bit that makes the number of ones in all 20 even. (Captures of real lines
// obey; parity over the position alone, as some descriptions have it, fits none of them.)

#include <cstdint>
#include <span>
#include <string>

#include "engrave/core/result.h"
#include "engrave/galvo/head_output.h"

namespace intaglio::galvo {

inline constexpr std::size_t kMaxXy2Frames = 200'000;  ///< of a capture: 2 s, 45 MB

/// The 20 bits of a position, the first sent is bit 19.
std::uint32_t Xy2Frame(std::uint16_t position);

/// kUnreadable: control bits that are not 001, parity, or more than 20 bits.
Result<std::uint16_t> ReadXy2Frame(std::uint32_t frame);

/// What a logic analyser would capture of these outputs, one each 10 us: a value change
/// dump (IEEE 1364-2005, 18) of CLK, SYNC, X, Y and LASER in steps of 250 ns. LASER
/// changes with the frame that holds its place. kTooLarge: more than kMaxXy2Frames.
Result<std::string> WriteXy2Capture(std::span<const HeadOutput> outputs);

}  // namespace intaglio::galvo
