#include "services/platform/link/unix_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "services/platform/link/endpoint.h"
#include "tests/test_folder.h"

namespace intaglio::link {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class UnixSocket : public ::testing::Test {
 protected:
  fs::path folder = test::FreshFolder() / "own";
  std::string path = (folder / "laser").string();
};

TEST_F(UnixSocket, IsOpenToItsUserAlone) {
  const auto listener = UnixListener::Listen(path);
  ASSERT_TRUE(listener) << listener.error().message;
  EXPECT_EQ(fs::status(path).permissions(), fs::perms(0600));
  EXPECT_EQ(fs::status(folder).permissions(), fs::perms(0700));
}

TEST_F(UnixSocket, AFolderThatOthersWriteIsRefused) {
  fs::create_directory(folder);
  ASSERT_EQ(chmod(folder.c_str(), 0777), 0);
  const auto listener = UnixListener::Listen(path);
  ASSERT_FALSE(listener);
  EXPECT_THAT(listener.error().message, HasSubstr(folder.string()));
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(UnixSocket, ASecondListenerIsRefusedWhileTheFirstLives) {
  auto first = UnixListener::Listen(path).value();
  const auto second = UnixListener::Listen(path);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("another program serves it"));
  (void)first->Accept();  // the question
  EXPECT_TRUE(OpenUnix(path));
  first.reset();
  EXPECT_FALSE(fs::exists(path));
  EXPECT_TRUE(UnixListener::Listen(path));
}

TEST_F(UnixSocket, TheFileOfAKilledListenerIsReplaced) {
  fs::create_directory(folder);
  ASSERT_EQ(chmod(folder.c_str(), 0700), 0);
  {
    auto killed = UnixListener::Listen(path).value();
    fs::create_hard_link(path, folder / "kept");
  }
  fs::rename(folder / "kept", path);
  const auto refused = OpenUnix(path);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("check that the program"));
  auto listener = UnixListener::Listen(path).value();
  auto host = OpenUnix(path).value();
  auto device = listener->Accept();
  ASSERT_NE(device, nullptr);
  const std::byte sent[3] = {std::byte{1}, std::byte{2}, std::byte{3}};
  EXPECT_EQ(host->Write(sent).value(), 3u);
  std::byte got[8];
  EXPECT_EQ(device->Read(got).value(), 3u);
}

TEST_F(UnixSocket, PathsThatCannotBeAreRefusedBeforeOpening) {
  EXPECT_FALSE(CheckDevice("unix:"));
  EXPECT_FALSE(CheckDevice("unix:laser"));
  EXPECT_TRUE(CheckDevice("unix:/" + std::string(kMaxUnixPath - 1, 'a')));
  const auto long_one = CheckDevice("unix:/" + std::string(kMaxUnixPath, 'a'));
  ASSERT_FALSE(long_one);
  EXPECT_THAT(long_one.error().message, HasSubstr("108 bytes, 107 are the most"));
}

}  // namespace
}  // namespace intaglio::link
