#include "services/job/models/reading_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <tuple>
#include <utility>
#include <vector>

#include "engrave/mesh/import/mesh_import.h"
#include "services/job/models/program_limits.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/test_meshes.h"
#include "tests/test_folder.h"

namespace intaglio::mesh_reader {
namespace {

namespace fs = std::filesystem;
using mesh::TriangleMesh;
using ::testing::HasSubstr;

constexpr char kIdentity[] = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

std::span<const std::byte> BytesOf(const std::string& file) {
  return std::as_bytes(std::span(file.data(), file.size()));
}

Result<TriangleMesh> ReadBy(const fs::path& program, const std::string& file,
                            std::string_view extension,
                            const mesh::ImportOptions& options = {}) {
  return ReadBy(ReadingProcess{program, std::chrono::seconds(1)})(
      BytesOf(file), extension, options, "box");
}

Result<TriangleMesh> Read(const std::string& file, std::string_view extension,
                          const mesh::ImportOptions& options = {}) {
  return ReadBy(fs::path(INTAGLIO_BIN_DIR) / "intaglio-mesh-reader", file, extension,
                options);
}

/// In the place of the program.
fs::path Script(const std::string& what) {
  const fs::path file = test::FreshFolder() / "reader";
  std::ofstream(file) << "#!/bin/sh\n" << what << "\n";
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

void ExpectRefused(const Result<TriangleMesh>& read, ErrorCode code,
                   const std::string& why) {
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, code) << read.error().message;
  EXPECT_THAT(read.error().message, HasSubstr("box"));
  EXPECT_THAT(read.error().message, HasSubstr(why));
}

/// A DAE whose places are names: the library reads the numbers that are not there.
std::string OfNames() {
  std::string dae = Dae(mesh::BoxMesh(Vec3(1, 2, 3)), "", kIdentity);
  for (std::size_t at = 0; (at = dae.find("float_array", at)) != std::string::npos;) {
    dae.replace(at, 11, "Name_array");
  }
  return dae;
}

TEST(ReadingProcess, GivesWhatTheLibraryGives) {
  const TriangleMesh box = mesh::BoxMesh(Vec3(1.0 / 3, 2, 3));
  const std::vector<std::pair<std::string, std::string>> files = {
      {Obj(box), "obj"},
      {Ply(box), ".PLY"},
      {Dae(box, "", kIdentity), "dae"},
      {Gltf(box, "1,0,0,0,0,1,0,0,0,0,1,0,4,5,6,1"), "gltf"},
      {ThreeMf(box, "inch", "0 1 0 -1 0 0 0 0 1 10 20 30"), "3mf"},
      {ThreeDs(box), "3ds"},
      {BinaryStl(box), "stl"}};
  for (const auto& [file, extension] : files) {
    const auto expected = mesh::ImportMeshFromMemory(BytesOf(file), extension);
    const auto read = Read(file, extension);
    ASSERT_TRUE(expected && read) << extension << (read ? "" : read.error().message);
    EXPECT_EQ(read->vertices, expected->vertices) << extension;
    EXPECT_EQ(read->triangles, expected->triangles) << extension;
  }
}

TEST(ReadingProcess, ReportsWhatTheLibrarysReaderReports) {
  mesh::ImportOptions few;
  few.max_triangles = 5;
  const std::string obj = Obj(mesh::BoxMesh(Vec3(1, 2, 3)));
  const std::vector<std::tuple<std::string, std::string, mesh::ImportOptions>> files = {
      {"", "obj", {}},
      {"v 0 0 0\n", "obj", {}},
      {obj, "obj", few},
      {obj, "dxf", {}},
      {"nothing", "3mf", {}}};
  for (const auto& [file, extension, options] : files) {
    const auto expected =
        mesh::ImportMeshFromMemory(BytesOf(file), extension, options, "box");
    const auto read = Read(file, extension, options);
    ASSERT_TRUE(!expected && !read) << extension;
    EXPECT_EQ(read.error().code, expected.error().code);
    EXPECT_EQ(read.error().message, expected.error().message);
    EXPECT_EQ(read.error().value, expected.error().value);
  }
}

TEST(ReadingProcess, AFileThatCrashesTheLibraryIsRefusedByName) {
  ExpectRefused(Read(OfNames(), "dae"), ErrorCode::kUnreadable,
                "it crashed the reader of dae files (Segmentation fault)");
  // A second copy is placed by a transform without numbers.
  ExpectRefused(Read(ThreeMf(mesh::BoxMesh(Vec3(1, 2, 3)), "inch", ""), "3mf"),
                ErrorCode::kUnreadable,
                "it cannot be read as 3mf (the transform \"\" is not twelve numbers)");
}

TEST(ReadingProcess, ANameThatResemblesAnOptionIsAName) {
  const auto read = ReadBy(ReadingProcess{
      fs::path(INTAGLIO_BIN_DIR) / "intaglio-mesh-reader", std::chrono::seconds(1)})(
      BytesOf("v 0 0 0\n"), "obj", {}, "--help.obj");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("--help.obj: it has no triangles"));
}

TEST(ReadingProcess, ChoosesObjectsByTheirNamesWhateverTheyResemble) {
  const std::string two =
      "o --help\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
      "o a;b\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 4 5 6\n";
  EXPECT_EQ(Read(two, "obj")->triangles.size(), 2u);
  for (const char* name : {"--help", "a;b"}) {
    const auto one = Read(two, "obj", {.objects = {name}});
    ASSERT_TRUE(one) << one.error().message;
    EXPECT_EQ(one->triangles.size(), 1u);
  }
  ExpectRefused(Read(two, "obj", {.objects = {"c"}}), ErrorCode::kMissing,
                "its objects are \"--help\", \"a;b\"");
}

TEST(ReadingProcess, OneThatIsKilledReportsIt) {
  ExpectRefused(ReadBy(Script("kill -9 $$"), "file", "obj"), ErrorCode::kUnreadable,
                "(Killed)");
}

TEST(ReadingProcess, OneThatReadsForEverIsEnded) {
  ExpectRefused(ReadBy(Script("while :; do :; done"), "file", "obj"),
                ErrorCode::kTooLarge, "more than 1 s of processor time");
}

TEST(ReadingProcess, OneThatTakesAllMemoryIsRefusedIt) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  mesh::ImportOptions small;
  small.max_triangles = 1000;
  // The bound comes when the process is there.
  const auto program = Script(
      "while [ $(ulimit -v) = unlimited ]; do sleep 0.01; done\n"
      "[ $(ulimit -v) -lt 1100000 ] && kill -9 $$");
  ExpectRefused(ReadBy(program, "file", "obj", small), ErrorCode::kUnreadable,
                "(Killed)");
#endif
}

TEST(ReadingProcess, WhatIsNoAnswerIsNone) {
  const std::string broke = "it crashed the reader of obj files";
  ExpectRefused(ReadBy(Script("echo a mesh"), "file", "obj"), ErrorCode::kUnreadable,
                broke);
  ExpectRefused(ReadBy(Script("exit 0"), "file", "obj"), ErrorCode::kUnreadable, broke);
  ExpectRefused(ReadBy(Script("exit 3"), "file", "obj"), ErrorCode::kUnreadable,
                "(exit code 3)");
}

TEST(ReadingProcess, WithoutItsProgramTheRemedyIsReported) {
  ExpectRefused(ReadBy("/no/such/program", "file", "obj"), ErrorCode::kNotFound,
                "/no/such/program cannot be started");
  EXPECT_TRUE(ReadBy("/no/such/program", BinaryStl(mesh::BoxMesh(Vec3(1, 2, 3))), "stl"));
}

// A link to it lies beside the tests.
TEST(ProgramLimits, SearchForTheProgramBesideTheOneThatRuns) {
  const ReadLimits limits = LimitsOfProgram(2);
  EXPECT_EQ(limits.meshes.max_triangles, 2 * mesh::ImportOptions{}.max_triangles);
  const TriangleMesh box = mesh::BoxMesh(Vec3(1, 2, 3));
  EXPECT_TRUE(limits.read_mesh(BytesOf(Obj(box)), "obj", limits.meshes, "box"));
  ExpectRefused(limits.read_mesh(BytesOf(OfNames()), "dae", limits.meshes, "box"),
                ErrorCode::kUnreadable, "it crashed the reader");
}

}  // namespace
}  // namespace intaglio::mesh_reader
