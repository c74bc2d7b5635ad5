#include "services/synchronizer/job_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

namespace intaglio::synchronizer {
namespace {

namespace fs = std::filesystem;

class JobFolderTest : public testing::Test {
 protected:
  JobFolderTest() {
    path_.Add(Vec3(0.1, 1.0 / 3, 1e-17), 4);
    path_.Add(Vec3(49.9, std::nextafter(2.0, 3.0), 30), 5);
  }
  ~JobFolderTest() override { fs::remove_all(folder_); }

  fs::path folder_ =
      fs::path(testing::TempDir()) / ("job-folder-" + std::to_string(getpid())) / "deep";
  PointCloud path_;
};

TEST_F(JobFolderTest, ThePathComesBackBitForBit) {
  ASSERT_TRUE(MakeJobFolder(folder_));
  ASSERT_TRUE(WritePlan(folder_, FrozenJob(), path_));
  const auto read = ReadPath(folder_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->points_mm, path_.points_mm);
  EXPECT_TRUE(fs::exists(folder_ / "job.json"));
}

TEST_F(JobFolderTest, NoPathMeansThatNothingWasEngraved) {
  const auto none = ReadPath(folder_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(none.error().message, testing::HasSubstr((folder_ / "path.ply").string()));
}

TEST_F(JobFolderTest, AFileInTheWayIsNamed) {
  fs::create_directories(folder_.parent_path());
  std::ofstream(folder_) << "no folder";
  const auto made = MakeJobFolder(folder_);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kIo);
  EXPECT_THAT(made.error().message, testing::HasSubstr(folder_.string()));
}

}  // namespace
}  // namespace intaglio::synchronizer
