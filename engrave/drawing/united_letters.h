#pragma once

// Letters that a script joins overlap: their outlines are one outline then, without the
// borders between them.

#include <cstdint>
#include <vector>

#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// `letters`: of each curve, which letter it is of. Curves of letters whose outlines
/// cross or touch each other are replaced by the outlines of what they run around
/// together, as lines that deviate by 1 um at most; all others stay exactly as they are.
/// Where edges nearly touch and cannot be told apart, the letters stay, too.
void UniteLetters(const std::vector<std::uint32_t>& letters, std::vector<Curve>& curves);

}  // namespace intaglio::drawing
