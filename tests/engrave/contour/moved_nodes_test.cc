#include <gtest/gtest.h>

#include <cmath>

#include "engrave/contour/union.h"
#include "tests/engrave/contour/boards.h"
#include "tests/engrave/contour/covered_area.h"

namespace intaglio::contour {
namespace {

// Nodes that are nearly equal leave outlines that nearly coincide, where every decision
// hangs on rounding. 300 boards, 30 for each distance from 1e-12 to 1e-3 mm: every result
// has the area that scan lines give, or is refused with a place on the board.
TEST(MovedNodes, GiveTheRightAreaOrAreRefusedWithThePlace) {
  int refused = 0;
  for (unsigned board_number = 0; board_number < 300; ++board_number) {
    const double moved = std::pow(10, -12 + static_cast<int>(board_number % 10));
    const auto board =
        test::MakeBoard({30, board_number + 1, board_number % 20 >= 10, moved});
    const auto united = Unite(board, {0.1});
    if (!united) {
      ++refused;
      EXPECT_EQ(united.error().code, ErrorCode::kUnsupported);
      EXPECT_NE(united.error().message.find(" at ("), std::string::npos);
      EXPECT_FALSE(united.error().value.empty());
      continue;
    }
    const auto rounded = Rounded(board);
    // Edges up to 4 nm apart may be taken for one; a lost or doubled element is 0.01 mm2.
    double length = 0;
    for (const Contour& contour : united->contours) length += contour.length_mm;
    EXPECT_NEAR(united->area_mm2, test::CoveredArea_mm2(*rounded, 0.1, 5), 4e-6 * length)
        << "board " << board_number << ", moved by " << moved;
  }
  // That it works at all, not only that it fails well.
  EXPECT_LE(refused, 3);
}

}  // namespace
}  // namespace intaglio::contour
