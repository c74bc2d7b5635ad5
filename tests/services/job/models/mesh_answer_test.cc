#include "services/job/models/mesh_answer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh_reader {
namespace {

using mesh::TriangleMesh;

template <typename T>
T At(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <typename T>
void Put(T value, std::size_t offset, std::vector<std::byte>& bytes) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

TEST(MeshAnswer, CarriesAMeshBitByBit) {
  TriangleMesh mesh = mesh::BoxMesh(Vec3(1.0 / 3, 1e-300, 7));
  const auto bytes = EncodeAnswer(mesh);
  const auto answer = ParseAnswer(bytes);
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ((*answer)->vertices, mesh.vertices);
  EXPECT_EQ((*answer)->triangles, mesh.triangles);
}

TEST(MeshAnswer, LiesAsItsHeaderStates) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
  const auto bytes = EncodeAnswer(mesh);
  ASSERT_EQ(bytes.size(), 48u + 4 * 24 + 2 * 12);
  EXPECT_EQ(std::memcmp(bytes.data(), "IMESH2\0\0", 8), 0);
  EXPECT_EQ(At<std::uint64_t>(bytes, 8), 0u);
  EXPECT_EQ(At<std::uint64_t>(bytes, 16), 4u);
  EXPECT_EQ(At<std::uint64_t>(bytes, 24), 2u);
  EXPECT_EQ(At<double>(bytes, 48 + 24 + 8), 5);
  EXPECT_EQ(At<std::uint32_t>(bytes, 48 + 4 * 24 + 12), 3u);

  const auto error = EncodeAnswer(Fail(ErrorCode::kTooLarge, "sentence", "12"));
  ASSERT_EQ(error.size(), 48u + 8 + 2);
  EXPECT_EQ(At<std::uint64_t>(error, 8), 7u);
  EXPECT_EQ(At<std::uint64_t>(error, 16), 8u);
  EXPECT_EQ(At<std::uint64_t>(error, 24), 2u);
  EXPECT_EQ(std::memcmp(error.data() + 48, "sentence12", 10), 0);
}

/// With two findings and the unit of its file.
mesh::ImportedMesh OfAFile() {
  mesh::ImportedMesh mesh(mesh::BoxMesh(Vec3(1, 2, 3)));
  mesh.declared_unit_mm = 25.4;
  mesh.findings.Add({.what = "skin",
                     .where = "mesh of \xC3\xA4",
                     .remedy = "apply it",
                     .count = 3,
                     .area_mm2 = 0.1,
                     .effect = Effect::kChanged});
  mesh.findings.Add({.what = "support",
                     .where = "",
                     .remedy = "",
                     .count = 1,
                     .effect = Effect::kNothingSeen});
  return mesh;
}

TEST(MeshAnswer, CarriesTheFindingsOfTheReader) {
  const mesh::ImportedMesh mesh = OfAFile();
  const auto answer = ParseAnswer(EncodeAnswer(mesh));
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ((*answer)->findings, mesh.findings);
  EXPECT_EQ((*answer)->declared_unit_mm, 25.4);
  EXPECT_EQ((*answer)->triangles, mesh.triangles);
}

TEST(MeshAnswer, CarriesEveryError) {
  for (int code = 0; code <= static_cast<int>(ErrorCode::kCancelled); ++code) {
    const Error error{static_cast<ErrorCode>(code), "what to do about it", ""};
    const auto answer = ParseAnswer(EncodeAnswer(tl::unexpected(error)));
    ASSERT_TRUE(answer && !*answer);
    EXPECT_EQ(answer->error().code, error.code);
    EXPECT_EQ(answer->error().message, error.message);
    EXPECT_EQ(answer->error().value, "");
  }
}

TEST(MeshAnswer, NoPartOfOneIsOne) {
  for (const Answer& answer :
       {Answer(OfAFile()), Answer(Fail(ErrorCode::kIo, "no", "1"))}) {
    auto bytes = EncodeAnswer(answer);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(ParseAnswer(std::span(bytes.data(), size))) << size;
    }
    bytes.push_back({});
    EXPECT_FALSE(ParseAnswer(bytes));
  }
}

TEST(MeshAnswer, IsNotBelievedWhenItContradictsItself) {
  const auto good = EncodeAnswer(mesh::BoxMesh(Vec3(1, 2, 3)));
  const std::size_t corners = 48 + 8 * 24;
  const auto with = [&good](auto value, std::size_t offset) {
    auto bytes = good;
    Put(value, offset, bytes);
    return ParseAnswer(bytes);
  };
  EXPECT_TRUE(with(std::uint32_t{7}, corners));
  EXPECT_FALSE(with(std::uint32_t{8}, corners)) << "a corner that is no vertex";
  EXPECT_FALSE(with(std::numeric_limits<double>::quiet_NaN(), 48)) << "no place";
  EXPECT_FALSE(with('1', 5)) << "another version";
  EXPECT_FALSE(with(std::uint64_t{15}, 8)) << "an error that there is not";
  EXPECT_FALSE(with(~std::uint64_t{0}, 32)) << "more findings than there are";
  EXPECT_FALSE(with(~std::uint64_t{0}, 16)) << "more than there is";
  // So many that their bytes come round to what is there.
  EXPECT_FALSE(with(std::uint64_t{8} + (std::uint64_t{1} << 61), 16));
}

// What would be written in another way is of another program.
TEST(MeshAnswer, IsAsItIsWritten) {
  auto refused = EncodeAnswer(Fail(ErrorCode::kIo, "no", "1"));
  ASSERT_TRUE(ParseAnswer(refused));
  for (const std::size_t offset : {32U, 40U}) {
    auto bytes = refused;
    Put(std::uint64_t{1}, offset, bytes);
    EXPECT_FALSE(ParseAnswer(bytes)) << "findings or a unit of no mesh";
  }
  // The second of two findings gets the name of the first.
  mesh::ImportedMesh made(mesh::BoxMesh(Vec3(1, 2, 3)), {});
  made.findings.Add({.what = "one", .where = "", .remedy = "", .count = 1});
  made.findings.Add({.what = "two", .where = "", .remedy = "", .count = 1});
  auto bytes = EncodeAnswer(made);
  ASSERT_TRUE(ParseAnswer(bytes));
  std::memcpy(bytes.data() + bytes.size() - 3, "one", 3);
  EXPECT_FALSE(ParseAnswer(bytes));
}

}  // namespace
}  // namespace intaglio::mesh_reader
