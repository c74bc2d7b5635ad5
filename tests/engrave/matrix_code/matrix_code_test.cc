#include "engrave/matrix_code/matrix_code.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/engrave/matrix_code/code_reader.h"

namespace intaglio::matrix_code {
namespace {

double AreaOf(const std::vector<Vec2>& outline) {
  double doubled = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 a = outline[i], b = outline[(i + 1) % outline.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return doubled / 2;
}

/// By a ray to the right.
bool IsEnclosed(const std::vector<std::vector<Vec2>>& outlines, const Vec2& p) {
  bool inside = false;
  for (const auto& outline : outlines) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vec2 a = outline[i], b = outline[(i + 1) % outline.size()];
      if ((a.y() > p.y()) != (b.y() > p.y()) && a.x() > p.x()) inside = !inside;
    }
  }
  return inside;
}

ModuleGrid GridOfRandom(int columns, int rows, std::mt19937& random) {
  ModuleGrid grid{columns, rows, {}};
  for (int i = 0; i < columns * rows; ++i) grid.dark.push_back(random() % 2 == 0);
  return grid;
}

TEST(ModuleOutlines, EncloseTheDarkModulesAndNothingElse) {
  std::mt19937 random(5);
  for (int k = 0; k < 50; ++k) {
    const ModuleGrid grid = GridOfRandom(1 + k % 9, 1 + k % 7, random);
    const auto outlines = ModuleOutlines(grid);
    double area = 0;
    for (const auto& outline : outlines) area += AreaOf(outline);
    EXPECT_NEAR(area, std::ranges::count(grid.dark, true), 1e-12);
    for (int row = 0; row < grid.rows; ++row)
      for (int column = 0; column < grid.columns; ++column)
        EXPECT_EQ(IsEnclosed(outlines, Vec2(column + 0.5, grid.rows - row - 0.5)),
                  grid.IsDark(column, row));
  }
}

// Corners alone; no outline touches itself.
TEST(ModuleOutlines, TurnAtEveryCornerAndKeepDiagonalNeighboursApart) {
  std::mt19937 random(6);
  for (int k = 0; k < 50; ++k) {
    for (const auto& outline : ModuleOutlines(GridOfRandom(8, 8, random))) {
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec2 a = outline[i], b = outline[(i + 1) % outline.size()],
                   c = outline[(i + 2) % outline.size()];
        EXPECT_EQ((b - a).dot(c - b), 0);
      }
    }
  }
  const auto diagonal = ModuleOutlines({2, 2, {true, false, false, true}});
  ASSERT_EQ(diagonal.size(), 2U);
  EXPECT_EQ(diagonal[0].size(), 4U);
  // A ring of dark modules: its hole runs clockwise.
  ModuleGrid ring{3, 3, std::vector<bool>(9, true)};
  ring.dark[4] = false;
  const auto outlines = ModuleOutlines(ring);
  ASSERT_EQ(outlines.size(), 2U);
  EXPECT_EQ(AreaOf(outlines[0]), 9);
  EXPECT_EQ(AreaOf(outlines[1]), -1);
}

/// Pixels of whole modules with a rim, as a printer makes them.
mark::BurntPicture Printed(const ModuleGrid& grid, int rim) {
  constexpr int kSide = 6;
  mark::BurntPicture picture;
  picture.width = kSide * (grid.columns + 2 * rim);
  picture.height = kSide * (grid.rows + 2 * rim);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      picture.pixels.push_back(grid.IsDark(x / kSide - rim, y / kSide - rim) ? 0 : 255);
  return picture;
}

TEST(MatrixCode, AnotherLibraryReadsDataMatrices) {
  if (!CanReadDataMatrix()) GTEST_SKIP() << "libdmtx is not installed";
  for (const std::string text :
       {"A", "SN-000123", "intaglio, a longer text: 0123456789"}) {
    const auto grid = MakeCode(text, {CodeKind::kDataMatrix});
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->columns, grid->rows);
    EXPECT_EQ(ReadDataMatrix(Printed(*grid, 3)), text);
  }
}

TEST(MatrixCode, AnotherLibraryReadsQrCodesOfEveryLevel) {
  if (!CanReadQr()) GTEST_SKIP() << "zbar is not installed";
  int columns = 0;
  for (const double ratio : {0.07, 0.15, 0.25, 0.3}) {
    const std::string text = "https://example.org/piece/0123456789/and/its/owner";
    const auto grid = MakeCode(text, {CodeKind::kQr, ratio});
    ASSERT_TRUE(grid);
    EXPECT_GE(grid->columns, columns);
    columns = grid->columns;
    EXPECT_EQ(ReadQr(Printed(*grid, 4)), text);
  }
  EXPECT_GT(columns, MakeCode("A", {CodeKind::kQr})->columns);
}

TEST(MatrixCode, AnInvertedGridHasARimAndTheOtherModules) {
  const ModuleGrid grid{2, 1, {true, false}};
  const ModuleGrid inverted = Inverted(grid, 1);
  EXPECT_EQ(inverted.columns, 4);
  EXPECT_EQ(inverted.rows, 3);
  EXPECT_FALSE(inverted.IsDark(1, 1));
  EXPECT_TRUE(inverted.IsDark(2, 1));
  EXPECT_TRUE(inverted.IsDark(0, 0));
}

TEST(MatrixCode, NamesWhatCannotBeCoded) {
  EXPECT_EQ(MakeCode("", {}).error().code, ErrorCode::kMissing);
  EXPECT_EQ(MakeCode(std::string(5000, 'x'), {}).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(MakeCode(std::string(50000, 'x'), {CodeKind::kQr}).error().code,
            ErrorCode::kTooLarge);
  const auto broken = MakeCode("\xff\xfe", {});
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code, ErrorCode::kUnreadable);
  EXPECT_NE(broken.error().message.find("Data Matrix"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::matrix_code
