#include "services/platform/access/users.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "services/platform/access/new_key.h"
#include "tests/test_folder.h"

namespace intaglio::access {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(Users, AHashIsOfArgon2idAndFitsItsPasswordAlone) {
  const std::string hash = HashOf("correct horse");
  EXPECT_THAT(hash, StartsWith("$argon2id$v=19$m=19456,t=2,p=1$"));
  EXPECT_NE(hash, HashOf("correct horse")) << "each has a salt of its own";
  EXPECT_TRUE(Matches(hash, "correct horse"));
  EXPECT_FALSE(Matches(hash, "correct horsf"));
  EXPECT_FALSE(Matches(hash, ""));
  EXPECT_FALSE(Matches("", "correct horse"));
  EXPECT_FALSE(Matches("correct horse", "correct horse"));
}

TEST(Users, AreWrittenAsTheyAreRead) {
  const fs::path file = test::FreshFolder() / "users";
  const std::vector<User> users = {{"anna", UserRole::kOperator, HashOf("correct horse")},
                                   {"Łukasz", UserRole::kObserver, HashOf("0123456789")}};
  ASSERT_TRUE(WriteUsers(file, users));
  EXPECT_EQ(fs::status(file).permissions() & fs::perms::mask,
            fs::perms::owner_read | fs::perms::owner_write);
  const auto read = ReadUsers(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(TextOf(*read), TextOf(users));
  EXPECT_THAT(TextOf(users), Not(HasSubstr("horse")));
  fs::permissions(file, fs::perms::group_read, fs::perm_options::add);
  const auto open = ReadUsers(file);
  ASSERT_FALSE(open);
  EXPECT_EQ(open.error().code, ErrorCode::kRefused);
  EXPECT_THAT(open.error().message, HasSubstr("chmod 600"));
  EXPECT_EQ(ReadUsers(file.string() + "2").error().code, ErrorCode::kNotFound);
}

TEST(Users, AWrongLineIsNamed) {
  const std::string hash = HashOf("correct horse");
  const std::vector<std::string> lines = {
      "anna",
      "anna:operator",
      "anna:admin:" + hash,
      ":observer:" + hash,
      "an na:observer:" + hash,
      "anna:observer:horse",
      "anna:observer:" + hash + " ",
      "anna:observer:$argon2id$" + std::string(200, 'a'),
      "bert:observer:" + hash};
  for (const std::string& line : lines) {
    const auto users = ParseUsers("bert:operator:" + hash + "\n" + line + "\n");
    ASSERT_FALSE(users) << line;
    EXPECT_THAT(users.error().message, HasSubstr("line 2")) << line;
  }
}

TEST(Users, PasswordsAndNamesHaveALength) {
  EXPECT_FALSE(CheckPassword("123456789"));
  EXPECT_TRUE(CheckPassword("1234567890"));
  EXPECT_FALSE(CheckPassword(std::string(257, 'a')));
  EXPECT_FALSE(CheckUserName(""));
  EXPECT_FALSE(CheckUserName("this computer")) << "the name of who has the key";
  EXPECT_FALSE(CheckUserName(std::string(65, 'a')));
  EXPECT_TRUE(CheckUserName("王芳"));
}

TEST(Users, KeysDiffer) {
  EXPECT_EQ(NewKey().size(), 64u);
  EXPECT_NE(NewKey(), NewKey());
}

}  // namespace
}  // namespace intaglio::access
