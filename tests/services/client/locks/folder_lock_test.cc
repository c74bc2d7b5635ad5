#include "services/client/locks/folder_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "services/client/child_process.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(FolderLock, IsHeldByOneAndGoesWithIt) {
  const fs::path folder = test::FreshFolder();
  {
    const auto first = FolderLock::Take(folder);
    ASSERT_TRUE(first) << first.error().message;
    // A child must not inherit it: it may outlive us.
    const auto child =
        ChildProcess::Start({"sleep", "/bin/sleep", {"60"}, folder / "output"});
    ASSERT_TRUE(child);
    std::error_code error;
    for (const auto& entry :
         fs::directory_iterator("/proc/" + std::to_string(child->pid()) + "/fd", error)) {
      EXPECT_NE(fs::read_symlink(entry, error), folder / "lock");
    }
    const auto second = FolderLock::Take(folder);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::kRefused);
    EXPECT_THAT(second.error().message, HasSubstr(std::to_string(getpid())));
    EXPECT_THAT(second.error().message, HasSubstr("--folder"));
  }
  EXPECT_TRUE(FolderLock::Take(folder));
}

TEST(FolderLock, NamesAFolderThatCannotBeWritten) {
  const auto lock = FolderLock::Take("/proc/no/such/place");
  ASSERT_FALSE(lock);
  EXPECT_EQ(lock.error().code, ErrorCode::kIo);
  EXPECT_THAT(lock.error().message, HasSubstr("/proc/no/such/place"));
}

}  // namespace
}  // namespace intaglio::client
