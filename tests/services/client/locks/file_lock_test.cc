#include "services/client/locks/file_lock.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

TEST(FileLock, IsHeldByOneUntilItIsGone) {
  const fs::path file = test::FreshFolder() / "lock";
  auto first = FileLock::TryLock(file);
  ASSERT_TRUE(first) << first.error().message;
  std::optional<FileLock> moved = std::move(*first);
  EXPECT_EQ(FileLock::TryLock(file).error().code, ErrorCode::kRefused);
  moved.reset();
  EXPECT_TRUE(FileLock::TryLock(file));
}

TEST(FileLock, RemovedFileHoldsNobodyBack) {
  const fs::path file = test::FreshFolder() / "lock";
  const auto first = FileLock::TryLock(file);
  ASSERT_TRUE(first);
  fs::remove(file);
  EXPECT_TRUE(FileLock::TryLock(file));
}

TEST(FileLock, ReplacesTheText) {
  const fs::path file = test::FreshFolder() / "lock";
  const auto lock = FileLock::TryLock(file);
  ASSERT_TRUE(lock);
  ASSERT_TRUE(lock->WriteText("a long text\n"));
  ASSERT_TRUE(lock->WriteText("short\n"));
  EXPECT_EQ(test::ContentOf(file), "short\n");
}

TEST(FileLock, FollowsNoLink) {
  const fs::path folder = test::FreshFolder();
  fs::create_symlink(folder / "elsewhere", folder / "lock");
  EXPECT_EQ(FileLock::TryLock(folder / "lock").error().code, ErrorCode::kIo);
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
}

}  // namespace
}  // namespace intaglio::client
