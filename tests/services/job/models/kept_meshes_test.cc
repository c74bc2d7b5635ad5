// A reader around which meshes are kept, against the reader itself.

#include "services/job/models/kept_meshes.h"

#include <gtest/gtest.h>

namespace intaglio {
namespace {

class KeptMeshesTest : public ::testing::Test {
 protected:
  Result<mesh::ImportedMesh> Read(const std::string& text,
                                  const std::string& name = "a.x",
                                  std::vector<std::string> objects = {}) {
    mesh::ImportOptions options;
    options.objects = std::move(objects);
    return reader_(std::as_bytes(std::span(text)), ".x", options, name);
  }

  int times_ = 0;  // that a file was read
  KeptMeshes kept_;
  mesh::MeshReader reader_ =
      kept_.Around([this](std::span<const std::byte> bytes, std::string_view extension,
                          const mesh::ImportOptions&,
                          std::string_view name) -> Result<mesh::ImportedMesh> {
        ++times_;
        EXPECT_EQ(extension, ".x");
        if (bytes.empty()) return Fail(ErrorCode::kUnreadable, std::string(name));
        mesh::TriangleMesh mesh;
        mesh.vertices.assign(bytes.size(), Vec3::Zero());
        return mesh::ImportedMesh(std::move(mesh));
      });
};

TEST_F(KeptMeshesTest, AFileIsReadOnce) {
  EXPECT_EQ(Read("four").value().vertices.size(), 4u);
  EXPECT_EQ(Read("four").value().vertices.size(), 4u);
  EXPECT_EQ(times_, 1);
}

TEST_F(KeptMeshesTest, OtherBytesNamesAndObjectsAreOtherMeshes) {
  (void)Read("four");
  EXPECT_EQ(Read("seconds").value().vertices.size(), 7u) << "it was written meanwhile";
  (void)Read("five");
  (void)Read("four", "b.x");
  (void)Read("four", "a.x", {"lid"});
  EXPECT_EQ(times_, 5);
  (void)Read("four", "a.x", {"lid"});
  EXPECT_EQ(times_, 5);
}

TEST_F(KeptMeshesTest, AnErrorIsNotKept) {
  EXPECT_FALSE(Read(""));
  EXPECT_FALSE(Read(""));
  EXPECT_EQ(times_, 2);
}

}  // namespace
}  // namespace intaglio
