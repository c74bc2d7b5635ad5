#include "engrave/formats/ply_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

using ::testing::HasSubstr;

PointTable TableOf(std::size_t count) {
  PointTable table;
  for (std::size_t i = 0; i < count; ++i)
    table.points_mm.push_back({0.1 * static_cast<double>(i), -2.5, 7});
  table.columns.push_back({"source", std::vector<std::uint32_t>(count, 3)});
  table.comments = {"mm"};
  return table;
}

/// All points, piece by piece.
Result<PointList> AllOf(PlyPoints& points) {
  PointList all;
  while (true) {
    auto piece = points.Next();
    if (!piece) return piece;
    if (piece->empty()) return all;
    EXPECT_LE(piece->size(), PlyPoints::kPieceCount);
    all.insert(all.end(), piece->begin(), piece->end());
  }
}

TEST(PlyPoints, GivesThePointsOfTheWholeFileTwice) {
  const auto file = test::FreshFolder() / "points.ply";
  for (const std::uint64_t count :
       {std::uint64_t{0}, std::uint64_t{5}, PlyPoints::kPieceCount,
        2 * PlyPoints::kPieceCount + 1}) {
    ASSERT_TRUE(WritePly(file, TableOf(count)));
    auto points = PlyPoints::Open(file);
    ASSERT_TRUE(points) << points.error().message;
    EXPECT_EQ(points->count(), count);
    EXPECT_EQ(*AllOf(*points), ReadPly(file)->points_mm);
    points->Rewind();
    EXPECT_EQ(AllOf(*points)->size(), count);
  }
}

TEST(PlyPoints, NamesThePlaceOfACut) {
  const auto file = test::FreshFolder() / "points.ply";
  ASSERT_TRUE(WritePly(file, TableOf(PlyPoints::kPieceCount + 10)));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  auto points = PlyPoints::Open(file);
  ASSERT_TRUE(points);
  const auto all = AllOf(*points);
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(all.error().message, HasSubstr("behind point 16384"));
}

TEST(PlyPoints, RefusesWhatIsNotOfPointsAlone) {
  const auto folder = test::FreshFolder();
  std::ofstream(folder / "text.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double "
         "y\nproperty double z\nend_header\n1 2 3\n";
  EXPECT_EQ(PlyPoints::Open(folder / "text.ply").error().code, ErrorCode::kUnsupported);
  std::ofstream(folder / "other.ply") << "no points";
  EXPECT_EQ(PlyPoints::Open(folder / "other.ply").error().code, ErrorCode::kUnreadable);
  EXPECT_EQ(PlyPoints::Open(folder / "none.ply").error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WritePly(folder / "many.ply", TableOf(5)));
  EXPECT_EQ(PlyPoints::Open(folder / "many.ply", {.max_points = 4}).error().code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::formats
