#include "services/client/machine/measured_marks.h"

#include <gmock/gmock.h>

#include <fstream>

#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class MeasuredMarksFile : public ::testing::Test {
 protected:
  Result<MeasuredMarks> Read(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return ReadMarks({folder_ / name});
  }
  std::string ErrorOf(const std::string& text) {
    const auto marks = Read("marks.csv", text);
    return marks ? "" : marks.error().message;
  }
  fs::path folder_ = test::FreshFolder();
};

TEST_F(MeasuredMarksFile, TablesHaveNumbersOrNot) {
  const auto plain = Read("a.csv", "x_mm,y_mm\n1.5,2\n-3,4e-1\n");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_THAT(plain->places_mm, ElementsAre(Vec2(1.5, 2), Vec2(-3, 0.4)));
  EXPECT_THAT(plain->numbers, IsEmpty());
  const auto numbered = Read("b.csv", "mark;y_mm;x_mm;note\n7;2,25;1,5;good\n1;0;0;\n");
  ASSERT_TRUE(numbered) << numbered.error().message;
  EXPECT_THAT(numbered->places_mm, ElementsAre(Vec2(1.5, 2.25), Vec2(0, 0)));
  EXPECT_THAT(numbered->numbers, ElementsAre(6, 0));
  const auto points = Read("c.xyz", "1 2 3\n4 5 6\n");
  ASSERT_TRUE(points);
  EXPECT_THAT(points->places_mm, ElementsAre(Vec2(1, 2), Vec2(4, 5)));
}

TEST_F(MeasuredMarksFile, MistakesNameLineAndField) {
  EXPECT_THAT(ErrorOf("x,y\n1,2\n"), HasSubstr("has no column x_mm"));
  EXPECT_THAT(ErrorOf("x_mm,y_mm\n1,2\n1,two\n"),
              HasSubstr("line 3, y_mm: 'two' is not a number"));
  EXPECT_THAT(ErrorOf("x_mm,y_mm\n1,nan\n"), HasSubstr("line 2, y_mm: 'nan'"));
  EXPECT_THAT(ErrorOf("x_mm,y_mm,mark\n1,2,0\n"),
              HasSubstr("line 2, mark: 0 is no number of a mark"));
  EXPECT_THAT(ErrorOf("x_mm,y_mm,mark\n1,2,1.5\n"), HasSubstr("mark: 1.5"));
}

// A picture has its y downwards; marks have theirs upwards.
TEST_F(MeasuredMarksFile, PicturesAreInMmAndSeenFromAbove) {
  render::Canvas canvas(400, 320);
  render::FillRect(canvas, {0, 0, 400, 320}, {render::Srgb(0x202020)});
  for (int i = 0; i < 20; ++i) {
    render::DrawDisc(canvas, Vec2(40 + 60 * (i % 5), 30 + 70 * (i / 5)), 5,
                     {render::Srgb(0xe0e0e0)});
  }
  ASSERT_TRUE(render::WritePng(folder_ / "p.png", canvas));
  const auto marks = ReadMarks({folder_ / "p.png", 20, 200});
  ASSERT_TRUE(marks) << marks.error().message;
  ASSERT_EQ(marks->places_mm.size(), 20u);
  // The canvas' pixel (i, j) covers i..i+1: its middle is at i + 0.5. Rows from the top.
  EXPECT_LT((marks->places_mm[0] - 0.02 * Vec2(39.5, -29.5)).norm(), 0.001);
  EXPECT_LT((marks->places_mm[19] - 0.02 * Vec2(279.5, -239.5)).norm(), 0.001);
  const auto none = ReadMarks({folder_ / "none.png", 20, 200});
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio::client
