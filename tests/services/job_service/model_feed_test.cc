#include "services/job_service/model_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "engrave/mesh/import/mesh_import.h"
#include "services/discretizer/model_intake.h"
#include "services/platform/bus/role_names.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using test::Eventually;
using ::testing::HasSubstr;

const std::string kScene = INTAGLIO_SOURCE_DIR "/tests/data/kinds/two_files/scene.gltf";

class ModelFeedTest : public testing::Test {
 protected:
  /// What a discretizer gets when it asks for these files.
  std::vector<FileBytes> Fetch(const std::vector<std::string>& files) {
    feed.Start({.job_uid = "j", .attempt = 1, .part = 0, .part_attempt = 1}, files);
    EXPECT_TRUE(intake.Open("j", 1, host::TaskPart{0, 1, 1}, files.size()));
    Result<bool> taken = false;
    Eventually([&] {
      taken = intake.Poll();
      failures = feed.TakeFailures();
      return !taken || *taken || !failures.empty();
    });
    return taken && *taken ? intake.TakeFiles() : std::vector<FileBytes>();
  }

  bus::Bus bus{test::PrivateBusOptions("", bus::kStageWorkerRole)};
  ModelFeed feed{bus};
  discretizer::ModelIntake intake{bus, "discretizer", {}};
  std::vector<ModelFeed::Failure> failures;
};

// A discretizer of another computer has no folder beside the model.
TEST_F(ModelFeedTest, AGltfGoesOutWithItsBuffers) {
  const auto files = Fetch({kScene});
  ASSERT_EQ(files.size(), 1u);
  const auto mesh = mesh::ImportMeshFromMemory(files[0], "gltf");
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->Bounds().size_mm(), Vec3(10, 20, 30));
}

TEST_F(ModelFeedTest, AGltfWithoutItsBufferIsReportedWithBothNames) {
  const auto folder = test::FreshFolder();
  std::filesystem::copy_file(kScene, folder / "scene.gltf");
  EXPECT_TRUE(Fetch({folder / "scene.gltf"}).empty());
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_THAT(failures[0].message, HasSubstr("scene.gltf: "));
  EXPECT_THAT(failures[0].message, HasSubstr("scene.bin: the file does not exist"));
}

TEST_F(ModelFeedTest, OtherFilesGoOutAsTheyAre) {
  const auto file = test::FreshFolder() / "three.xyz";
  const std::string text(200'000, '7');
  std::ofstream(file) << text;
  const auto files = Fetch({file, file});
  ASSERT_EQ(files.size(), 2u);
  const auto bytes = std::as_bytes(std::span(text));
  EXPECT_EQ(files[0], FileBytes(bytes.begin(), bytes.end()));
  EXPECT_EQ(files[1], files[0]);
}

}  // namespace
}  // namespace intaglio::job_service
