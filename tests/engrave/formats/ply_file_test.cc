#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include "engrave/core/check.h"
#include "engrave/formats/point_file.h"
#include "tests/engrave/discretize/figurines.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

namespace fs = std::filesystem;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Doubles of every magnitude, chosen by their bits.
double AnyFinite(std::mt19937_64& random) {
  for (;;) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) return value;
  }
}

bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

template <typename T>
void AppendReversed(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

TEST(PlyFile, RoundTripKeepsEveryBit) {
  std::mt19937_64 random(11);
  PointTable table;
  std::vector<double> tick;
  std::vector<float> energy_uj;
  std::vector<std::int32_t> offset;
  std::vector<std::uint32_t> place;
  std::vector<std::uint8_t> channel;
  for (int i = 0; i < 20'000; ++i) {
    table.points_mm.emplace_back(AnyFinite(random), AnyFinite(random), AnyFinite(random));
    tick.push_back(static_cast<double>(random() >> 11));  // up to 2^53
    energy_uj.push_back(static_cast<float>(AnyFinite(random)));
    offset.push_back(static_cast<std::int32_t>(random()));
    place.push_back(static_cast<std::uint32_t>(random()));
    channel.push_back(static_cast<std::uint8_t>(random()));
  }
  table.points_mm[0] = Vec3(-0.0, std::numeric_limits<double>::denorm_min(),
                            std::numeric_limits<double>::max());
  tick[0] = std::numeric_limits<double>::infinity();  // a column may hold anything
  table.columns = {{"tick", tick},
                   {"energy_uj", energy_uj},
                   {"offset", offset},
                   {"place", place},
                   {"channel", channel}};
  table.comments = {"glass frame, mm", "", "  two blanks first"};
  const fs::path file = test::FreshFolder() / "cloud.ply";
  ASSERT_TRUE(WritePly(file, table).has_value());
  const auto read = ReadPly(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->points_mm.size(), table.points_mm.size());
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_TRUE(SameBits(read->points_mm[i][axis], table.points_mm[i][axis])) << i;
    }
  }
  EXPECT_EQ(read->columns, table.columns);
  EXPECT_EQ(read->comments, table.comments);
  EXPECT_EQ(*read->Find<double>("tick"), tick);
  EXPECT_EQ(read->Find<float>("tick"), nullptr) << "of another type";
  EXPECT_EQ(read->Find<double>("absent"), nullptr);
}

TEST(PlyFile, HasTheHeaderThatOtherProgramsRead) {
  PointTable table;
  table.points_mm = {{1, 2, 3}};
  table.columns = {{"tick", std::vector<double>{7}},
                   {"channel", std::vector<std::uint8_t>{65}}};
  table.comments = {"made by a test"};
  const fs::path file = test::FreshFolder() / "one.ply";
  ASSERT_TRUE(WritePly(file, table).has_value());
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment made by a test\nelement vertex 1\n"
      "property double x\nproperty double y\nproperty double z\n"
      "property double tick\nproperty uchar channel\nend_header\n";
  const std::string content = test::ContentOf(file);
  EXPECT_EQ(content.substr(0, header.size()), header);
  ASSERT_EQ(content.size(), header.size() + 4 * 8 + 1);
  EXPECT_EQ(content.back(), 'A');
  // 1.0 in little-endian order.
  EXPECT_EQ(content.substr(header.size(), 8), std::string("\0\0\0\0\0\0\xF0\x3F", 8));
}

TEST(PlyFile, WithoutPointsIsStillAFile) {
  const fs::path file = test::FreshFolder() / "none.ply";
  ASSERT_TRUE(WritePly(file, {}).has_value());
  const auto read = ReadPly(file);
  ASSERT_TRUE(read.has_value());
  EXPECT_THAT(read->points_mm, IsEmpty());
}

TEST(PlyFile, ReadsAsciiOfAnyOrderAndKind) {
  const auto table = ParsePly(
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info whatever\r\n"
      "element camera 2\r\nproperty list uchar float view\r\nproperty int id\r\n"
      "element vertex 2\r\nproperty uchar red\r\nproperty float z\r\n"
      "property list uint8 int32 neighbours\r\nproperty float x\r\n"
      "property double y\r\nproperty short group\r\n"
      "element face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n"
      "2 0.5 0.25 9\r\n0 8\r\n"
      "255 0.1 3 7 8 9 +2 0.1 -5\r\n"
      "0 nan_is_not_here_but_in_the_next_test");
  ASSERT_FALSE(table.has_value());
  EXPECT_THAT(table.error().message, HasSubstr("row 2 of the 2 of element vertex"));

  const auto whole = ParsePly(
      "ply\nformat ascii 1.0\ncomment by hand\nelement camera 1\n"
      "property list uchar float view\nproperty int id\nelement vertex 2\n"
      "property uchar red\nproperty float z\nproperty list uint8 int32 neighbours\n"
      "property float x\nproperty double y\nproperty short group\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "2 0.5 0.25 9\n255 0.1 3 7 8 9 +2 0.1 -5\n1.0 4 0 5 6 7\n3 0 1 0\n");
  ASSERT_TRUE(whole.has_value()) << whole.error().message;
  // z is a float property: 0.1 is that float, y is the double.
  EXPECT_THAT(whole->points_mm, ElementsAre(Vec3(2, 0.1, double{0.1f}), Vec3(5, 6, 4)));
  EXPECT_EQ(*whole->Find<std::uint8_t>("red"), (std::vector<std::uint8_t>{255, 1}));
  EXPECT_EQ(*whole->Find<std::int32_t>("group"), (std::vector<std::int32_t>{-5, 7}));
  EXPECT_EQ(whole->columns.size(), 2u);
  EXPECT_THAT(whole->comments, ElementsAre("by hand"));
}

TEST(PlyFile, ReadsBigEndian) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property double y\nproperty int z\nproperty ushort group\nend_header\n";
  AppendReversed(bytes, 1.5f);
  AppendReversed(bytes, -2.25);
  AppendReversed(bytes, std::int32_t{-3});
  AppendReversed(bytes, std::uint16_t{65535});
  const auto table = ParsePly(bytes);
  ASSERT_TRUE(table.has_value()) << table.error().message;
  EXPECT_THAT(table->points_mm, ElementsAre(Vec3(1.5, -2.25, -3)));
  EXPECT_EQ(*table->Find<std::int32_t>("group"), (std::vector<std::int32_t>{65535}));
}

TEST(PlyFile, ReadsTheVerticesOfAColouredMesh) {
  const mesh::TriangleMesh row = discretize::InARow(discretize::Figurine(2), 112);
  const auto table = ParsePly(mesh::BinaryPly(row));
  ASSERT_TRUE(table.has_value()) << table.error().message;
  ASSERT_EQ(table->points_mm.size(), row.vertices.size());
  for (std::size_t i = 0; i < row.vertices.size(); ++i) {
    ASSERT_EQ(table->points_mm[i], row.vertices[i].cast<float>().cast<double>()) << i;
  }
  EXPECT_EQ(table->columns.size(), 4u);
  ASSERT_NE(table->Find<std::uint8_t>("alpha"), nullptr);
  EXPECT_THAT(*table->Find<std::uint8_t>("alpha"), Each(255));
}

TEST(PlyFile, CutAnywhereIsAnErrorThatNamesTheRow) {
  const fs::path file = test::FreshFolder() / "cut.ply";
  PointTable table;
  table.points_mm = {{1, 2, 3}, {4, 5, 6}};
  ASSERT_TRUE(WritePly(file, table).has_value());
  const std::string content = test::ContentOf(file);
  for (std::size_t size = 0; size < content.size(); ++size) {
    const auto read = ParsePly(std::string_view(content).substr(0, size));
    ASSERT_FALSE(read.has_value()) << size;
    EXPECT_EQ(read.error().code, ErrorCode::kUnreadable);
  }
  std::ofstream(file, std::ios::binary) << content.substr(0, content.size() - 1);
  const auto read = ReadPly(file);
  ASSERT_FALSE(read.has_value());
  EXPECT_THAT(read.error().message, HasSubstr("cut.ply: the file ends, or is damaged, in "
                                              "row 2 of the 2 of element vertex"));
}

ErrorCode CodeOf(std::string_view bytes, const PointFileLimits& limits = {}) {
  const auto table = ParsePly(bytes, limits);
  EXPECT_FALSE(table.has_value()) << bytes;
  return table ? ErrorCode::kFault : table.error().code;
}

std::string AsciiPly(const std::string& rest) { return "ply\nformat ascii 1.0\n" + rest; }

// More rows than declared, or more values in a row, which would be taken for the next
// point.
TEST(PlyFile, WhatGoesOnBehindItsLastRowIsRefused) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  EXPECT_TRUE(ParsePly(header + "1 1 1\n2 2 2\n \r\n"));
  for (const char* rows : {"1 1 1\n2 2 2\n3 3 3\n", "1 1 1 255 0 0\n2 2 2 255 0 0\n"}) {
    const auto table = ParsePly(header + rows);
    ASSERT_FALSE(table) << rows;
    EXPECT_THAT(table.error().message, HasSubstr("goes on behind its last vertex"));
  }
  const fs::path file = test::FreshFolder() / "more.ply";
  PointTable table;
  table.points_mm = {Vec3(1, 2, 3), Vec3(4, 5, 6)};
  ASSERT_TRUE(WritePly(file, table));
  ASSERT_TRUE(ReadPly(file));
  std::ofstream(file, std::ios::app | std::ios::binary) << std::string(24, '\1');
  EXPECT_EQ(ReadPly(file).error().code, ErrorCode::kUnreadable);
}

TEST(PlyFile, RefusesWhatIsNoPointFile) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(CodeOf(""), ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf("solid box\n"), ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf("ply\nend_header\n"), ErrorCode::kUnreadable) << "no format";
  EXPECT_EQ(CodeOf("ply\nformat ascii 2.0\nend_header\n"), ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf(AsciiPly("end_header\n")), ErrorCode::kMissing);
  EXPECT_EQ(CodeOf(AsciiPly("property float x\nend_header\n")), ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf(AsciiPly("element vertex -1\n" + xyz + "end_header\n")),
            ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf(AsciiPly("element vertex 1\nproperty list float int x\nend_header\n")),
            ErrorCode::kUnreadable);
  EXPECT_EQ(CodeOf(AsciiPly("element vertex 1\nproperty float x\nend_header\n1\n")),
            ErrorCode::kMissing);
  EXPECT_EQ(
      CodeOf(AsciiPly("element vertex 1\n" + xyz + xyz + "end_header\n1 2 3 4 5 6")),
      ErrorCode::kMissing)
      << "which x?";
  EXPECT_EQ(CodeOf(AsciiPly("element vertex 1\n" + xyz + "end_header\n1 nan 3\n")),
            ErrorCode::kInvalidValue);
  EXPECT_EQ(CodeOf(AsciiPly("element vertex 1\nproperty uchar red\n" + xyz +
                            "end_header\n256 1 2 3\n")),
            ErrorCode::kUnreadable);
}

TEST(PlyFile, AllocatesNothingForACountThatCannotBe) {
  const std::string header = AsciiPly(
      "element vertex 19000000\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n1 2 3\n");
  EXPECT_EQ(CodeOf(header), ErrorCode::kUnreadable);
  PointFileLimits limits;
  limits.max_points = 18'999'999;
  EXPECT_EQ(CodeOf(header, limits), ErrorCode::kTooLarge);
}

TEST(PlyFile, KeepsTheLimitOnTheFile) {
  const fs::path file = test::FreshFolder() / "cloud.ply";
  ASSERT_TRUE(WritePly(file, {}).has_value());
  PointFileLimits limits;
  limits.max_file_bytes = fs::file_size(file) - 1;
  const auto read = ReadPly(file, limits);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(ReadPly("/nonexistent.ply").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(ReadPly("/").error().code, ErrorCode::kIo);
}

TEST(PlyFile, RefusesToWriteWhatCouldNotBeRead) {
  const fs::path file = test::FreshFolder() / "cloud.ply";
  PointTable table;
  table.points_mm = {{1, 2, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_THROW((void)WritePly(file, table), PreconditionError);
  table.points_mm = {{1, 2, 3}};
  table.columns = {{"tick", std::vector<double>{}}};
  EXPECT_THROW((void)WritePly(file, table), PreconditionError);
  table.columns = {{"a name", std::vector<double>{1}}};
  EXPECT_THROW((void)WritePly(file, table), PreconditionError);
  table.columns = {};
  table.comments = {"two\nlines"};
  EXPECT_THROW((void)WritePly(file, table), PreconditionError);
}

}  // namespace
}  // namespace intaglio::formats
