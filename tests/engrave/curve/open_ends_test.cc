#include "engrave/curve/open_ends.h"

#include <gtest/gtest.h>

namespace intaglio::curve {
namespace {

std::optional<CurveEnds> Line(double x, double y, double to_x, double to_y,
                              std::int64_t layer = 0) {
  return CurveEnds{layer, {x, y, 0}, {to_x, to_y, 0}};
}

TEST(OpenEnds, MeetWhereExactlyTwoAreNear) {
  const OpenEnds ends({Line(0, 0, 1, 0), Line(1.009, 0, 2, 0), Line(3, 0, 2, 0.011)},
                      0.01);
  EXPECT_EQ(ends.PartnerOf(1), 2u);
  EXPECT_EQ(ends.PartnerOf(2), 1u);
  EXPECT_EQ(ends.PartnerOf(3), kNoEnd) << "farther than the tolerance";
  EXPECT_EQ(ends.FirstOfChain(2), 0u);
  EXPECT_EQ(ends.FirstOfChain(4), 4u);
}

TEST(OpenEnds, DoNotMeetAtABranchNorAcrossLayersNorAtWhatIsClosed) {
  const OpenEnds branch({Line(0, 0, 1, 0), Line(1, 0, 2, 0), Line(1, 0, 1, 1)}, 0.01);
  EXPECT_EQ(branch.PartnerOf(1), kNoEnd);
  const OpenEnds layers({Line(0, 0, 1, 0), Line(1, 0, 2, 0, 1)}, 0.01);
  EXPECT_EQ(layers.PartnerOf(1), kNoEnd);
  const OpenEnds closed({Line(0, 0, 1, 0), std::nullopt, Line(1, 0, 2, 0)}, 0.01);
  EXPECT_EQ(closed.PartnerOf(1), 4u);
  EXPECT_EQ(closed.PartnerOf(2), kNoEnd);
}

// The nearest end is not taken where the other one is nearer to a third.
TEST(OpenEnds, AgreeOnBothSides) {
  const OpenEnds ends({Line(0, 0, 1, 0), Line(1.008, 0, 2, 0), Line(1.016, 0, 1, 5)},
                      0.01);
  EXPECT_EQ(ends.PartnerOf(1), kNoEnd);
  EXPECT_EQ(ends.PartnerOf(2), kNoEnd);
}

TEST(OpenEnds, GoRoundARing) {
  const OpenEnds ends({Line(0, 0, 1, 0), Line(1, 0, 1, 1), Line(0, 0, 1, 1)}, 0.01);
  EXPECT_EQ(ends.FirstOfChain(0), 0u);
  End end = 0;
  int count = 0;
  do {
    end = ends.PartnerOf(OtherEnd(end));
    ++count;
  } while (end != 0 && count < 10);
  EXPECT_EQ(count, 3);
}

}  // namespace
}  // namespace intaglio::curve
