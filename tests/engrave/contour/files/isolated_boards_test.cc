// Three boards as people draw them, from the file to the copper that is left: isolated,
// their nets proved, and refused by name with a tool that is too wide.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engrave/contour/files/kicad_read.h"
#include "engrave/contour/isolation.h"
#include "engrave/contour/milling/nets.h"
#include "tests/engrave/contour/files/kicad_text.h"

namespace intaglio::contour {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Both sides of a board milled with a tool.
Result<NetReport> MilledNets(const KicadBoard& board, double tool_mm, int passes) {
  const auto sheet = RegionOfLoops(board.outline);
  EXPECT_TRUE(sheet) << sheet.error().message;
  std::vector<Region> copper;
  for (std::uint32_t layer = 0; layer < board.layers.size(); ++layer) {
    const auto isolation = Isolate(ElementsOfLayer(board, layer), {tool_mm, passes});
    if (!isolation) return tl::unexpected(isolation.error());
    auto left = CopperLeft(*sheet, *isolation, tool_mm);
    if (!left) return tl::unexpected(left.error());
    copper.push_back(std::move(*left));
  }
  return CompareNets(copper, board.elements);
}

struct Case {
  const char* name;
  test::KicadText text;
  double tool_mm;
  double too_wide_mm;
  const char* refusal;
};

std::vector<Case> Boards() {
  // Gaps by hand: the ladder's diagonals are 10 mm sin(atan(2)) apart, 0.5 wide, pads of
  // 1.8 between them; the circuit's pads have 1.27 - 0.6; the plane's pads 1.5 - 0.9.
  return {{"ladder", test::LadderBoard(), 0.4, 8, "cannot isolate"},
          {"fan", test::FanBoard(), 0.3, 0.7, "gap 0.67 < tool 0.7"},
          {"plane", test::PlaneBoard(), 0.5, 0.65, "gap 0.6 < tool 0.65"}};
}

TEST(IsolatedBoards, HaveTheNetsThatWereDrawn) {
  for (const Case& board : Boards()) {
    SCOPED_TRACE(board.name);
    const auto read = ReadKicadBoard(board.text.Text(), board.name);
    ASSERT_TRUE(read) << read.error().message;
    for (const int passes : {1, 2}) {
      const auto report = MilledNets(*read, board.tool_mm, passes);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->net_count, board.text.NetCount());
      for (const NetFault& fault : report->faults) ADD_FAILURE() << fault.sentence;
    }
  }
}

TEST(IsolatedBoards, AreRefusedByNameWithTooWideATool) {
  for (const Case& board : Boards()) {
    SCOPED_TRACE(board.name);
    const auto read = ReadKicadBoard(board.text.Text(), board.name);
    ASSERT_TRUE(read) << read.error().message;
    const auto report = MilledNets(*read, board.too_wide_mm, 1);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(report.error().message, HasSubstr(board.refusal));
  }
}

// Faults put in on purpose, each found with its net and its place.
TEST(IsolatedBoards, FaultsAreFoundWithTheirPlace) {
  test::KicadText shorted = test::LadderBoard();
  shorted.Segment(115, 110, 125, 110, 0.4, "N1");  // from one diagonal to the next
  const auto board = ReadKicadBoard(shorted.Text(), "shorted");
  ASSERT_TRUE(board) << board.error().message;
  const auto report = MilledNets(*board, 0.4, 1);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->faults.size(), 1U);
  EXPECT_EQ(report->faults[0].kind, FaultKind::kShort);
  EXPECT_EQ(report->faults[0].net + " " + report->faults[0].other_net, "N1 N2");
  EXPECT_LT((report->faults[0].place_mm - Vec2(125, -110)).norm(), 0.6);

  test::KicadText broken = test::FanBoard();
  std::string text = broken.Text();
  const std::string via = " (via (at 96 58)";
  text.replace(text.find(via), via.size(), " (via (at 96 52)");
  const auto open = ReadKicadBoard(text, "broken");
  ASSERT_TRUE(open) << open.error().message;
  const auto opened = MilledNets(*open, 0.3, 1);
  ASSERT_TRUE(opened) << opened.error().message;
  ASSERT_GE(opened->faults.size(), 1U);
  for (const NetFault& fault : opened->faults) {
    EXPECT_EQ(fault.kind, FaultKind::kOpen);
    EXPECT_EQ(fault.net, "GND");
  }
}

}  // namespace
}  // namespace intaglio::contour
