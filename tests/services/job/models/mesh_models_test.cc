#include "services/job/models/mesh_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "services/job/models/model_file.h"
#include "tests/services/job/models/all_formats.h"
#include "tests/services/job/models/one_model.h"
#include "tests/test_folder.h"
#include "tests/test_name.h"

namespace intaglio {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;

const std::string kMeshFiles = INTAGLIO_SOURCE_DIR "/tests/data/kinds/";

Warnings WarningsOfMaking(const JobSpec& job) {
  const JobSpec whole = WithDefaults(job, GoodMachine());
  const auto files = ReadFilesOf(whole, {});
  EXPECT_TRUE(files) << files.error().message;
  const auto made = MakeSources(whole, *files, AllFormats(), {});
  EXPECT_TRUE(made) << made.error().message;
  return made ? made->warnings : Warnings();
}

TEST(MeshModels, WhatTheReaderDidNotObeyIsAWarningOfTheJob) {
  OneModel one;
  one.model.set_file(kMeshFiles + "skin.glb");
  const Warnings warnings = WarningsOfMaking(one.job);
  EXPECT_THAT(warnings,
              Contains(AllOf(Field(&Warning::code, WarningCode::kLeftOut),
                             Field(&Warning::weight, WarningWeight::kWarning),
                             Field(&Warning::text, HasSubstr("skin.glb: 1 x skin")))));
}

// Another model's buffer of the same name is in the working directory.
TEST(MeshModels, AGltfIsReadWithTheBuffersOfItsFolder) {
  const auto before = std::filesystem::current_path();
  const auto folder = test::FreshFolder();
  std::ofstream(folder / "scene.bin") << std::string(1000, '\0');
  std::filesystem::current_path(folder);
  OneModel one;
  one.model.set_file(kMeshFiles + "two_files/scene.gltf");
  const auto sizes = SizesOf(WithDefaults(one.job, GoodMachine()), AllFormats());
  std::filesystem::current_path(before);
  ASSERT_TRUE(sizes) << sizes.error().message;
  // It has y up.
  EXPECT_EQ(sizes->front().size_mm, Vec3(10, 30, 20));
}

TEST(MeshModels, ABufferThatIsNotInTheFolderIsRefusedByName) {
  const auto folder = test::FreshFolder();
  const auto refused = [&](const std::string& uri) {
    std::ofstream(folder / "scene.gltf")
        << "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":168,\"uri\":\""
        << uri << "\"}]}";
    const auto whole = ReadModelFile(folder / "scene.gltf", 1000);
    EXPECT_FALSE(whole) << uri;
    return whole ? "" : whole.error().message;
  };
  EXPECT_THAT(refused("scene.bin"), HasSubstr("scene.bin: the file does not exist"));
  EXPECT_THAT(refused(kMeshFiles + "two_files/scene.bin"),
              HasSubstr("scene.gltf: its buffer"));
  EXPECT_THAT(refused("../scene.bin"), HasSubstr("../scene.bin"));
  std::ofstream(folder / "scene.bin") << std::string(900, '\0');
  EXPECT_THAT(refused("scene.bin"), HasSubstr("more than the 1000 bytes allowed"));
}

struct UnitOfFile {
  const char* file;
  Vec3 size_mm;  ///< by the unit that it declares, the inch
};

class UnitsOfMeshes : public ::testing::TestWithParam<UnitOfFile> {};

TEST_P(UnitsOfMeshes, AreThoseOfTheFileUnlessTheJobHasOne) {
  OneModel one;
  one.model.set_file(kMeshFiles + GetParam().file);
  const auto size = [&] {
    const auto sizes = SizesOf(WithDefaults(one.job, GoodMachine()), AllFormats());
    EXPECT_TRUE(sizes) << sizes.error().message;
    return sizes ? sizes->front() : ModelSize();
  };
  // The numbers of the files have six digits.
  EXPECT_TRUE(size().size_mm.isApprox(GetParam().size_mm, 1e-5)) << size().size_mm;
  EXPECT_DOUBLE_EQ(size().unit_mm, 25.4);
  one.model.mutable_placement()->set_unit_mm(5);
  EXPECT_TRUE(size().size_mm.isApprox(GetParam().size_mm * (5 / 25.4), 1e-5))
      << size().size_mm;
  EXPECT_DOUBLE_EQ(size().unit_mm, 5);
  EXPECT_THAT(WarningsOfMaking(one.job),
              Contains(AllOf(
                  Field(&Warning::weight, WarningWeight::kNote),
                  Field(&Warning::text, HasSubstr("5 mm, as the job asks, instead of the "
                                                  "25.4 mm that the file declares")))));
  // The same as the file's is no news.
  one.model.mutable_placement()->set_unit_mm(25.4);
  EXPECT_TRUE(size().size_mm.isApprox(GetParam().size_mm, 1e-5)) << size().size_mm;
}

INSTANTIATE_TEST_SUITE_P(Files, UnitsOfMeshes,
                         ::testing::Values(UnitOfFile{"unit.3mf", {20, 30, 40}},
                                           UnitOfFile{"unit.dae", {25.4, 50.8, 76.2}}),
                         [](const auto& row) {
                           return test::AsTestName(row.param.file);
                         });

}  // namespace
}  // namespace intaglio
