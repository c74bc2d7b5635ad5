#include "services/client/fresh_paths.h"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>

#include "services/client/locks/folder_lock.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

void Touch(const fs::path& file) {
  fs::create_directories(file.parent_path());
  std::ofstream{file} << "x";
}

TEST(FreshPaths, WhatWasMadeGoesAndWhatWasThereStays) {
  const fs::path folder = test::FreshFolder();
  Touch(folder / "there" / "kept");
  {
    const FreshPaths fresh({folder / "there", folder / "there" / "lock",
                            folder / "deep" / "er" / "base.db", folder / "never"});
    Touch(folder / "there" / "lock");
    Touch(folder / "deep" / "er" / "base.db");
  }
  EXPECT_TRUE(fs::exists(folder / "there" / "kept"));
  EXPECT_FALSE(fs::exists(folder / "there" / "lock"));
  EXPECT_FALSE(fs::exists(folder / "deep"));
}

TEST(FreshPaths, NothingGoesWhenItIsKept) {
  const fs::path folder = test::FreshFolder();
  {
    FreshPaths fresh({folder / "shop"});
    Touch(folder / "shop" / "lock");
    fresh.Keep();
  }
  EXPECT_TRUE(fs::exists(folder / "shop" / "lock"));
}

// A refused process removes its lock file; a process that opened the same file before
// must not take the lock of a file that nobody else finds.
TEST(FreshPaths, ARemovedLockFileLocksNothing) {
  const fs::path folder = test::FreshFolder() / "shop";
  std::optional<FolderLock> refused;
  {
    const FreshPaths fresh({folder});
    auto taken = FolderLock::Take(folder);
    ASSERT_TRUE(taken) << taken.error().message;
    refused.emplace(std::move(*taken));
  }
  EXPECT_FALSE(fs::exists(folder));
  const auto next = FolderLock::Take(folder);
  ASSERT_TRUE(next) << "it is another file";
  EXPECT_FALSE(FolderLock::Take(folder));
}

TEST(FreshPaths, ThereIsRoomHere) {
  EXPECT_TRUE(CheckRoom(test::FreshFolder() / "not" / "yet"));
}

}  // namespace
}  // namespace intaglio::client
