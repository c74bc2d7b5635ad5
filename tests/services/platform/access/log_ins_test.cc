#include "services/platform/access/log_ins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/test_folder.h"

namespace intaglio::access {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class LogInsOfTwo : public ::testing::Test {
 protected:
  void SetUp() override { Write(anna_); }
  void Write(const User& anna) {
    ASSERT_TRUE(WriteUsers(file_, {anna, {"bert", UserRole::kObserver, bert_hash_}}));
  }
  Result<LogIns::Opened> Try(const std::string& password,
                             const std::string& name = "anna",
                             const std::string& address = "192.0.2.1") {
    return log_ins_.LogIn(name, password, address, now_);
  }
  ErrorCode WhyNot(const std::string& password, const std::string& name = "anna",
                   const std::string& address = "192.0.2.1") {
    const auto opened = Try(password, name, address);
    EXPECT_FALSE(opened);
    return opened ? ErrorCode::kFault : opened.error().code;
  }

  const std::filesystem::path file_ = test::FreshFolder() / "users";
  User anna_{"anna", UserRole::kOperator, HashOf("right password")};
  std::string bert_hash_ = HashOf("another password");
  LogIns log_ins_{file_, {.session_count = 3}};
  LogIns::Clock::time_point now_{1000h};
};

TEST_F(LogInsOfTwo, ATokenIsTheSessionUntilItsEnd) {
  const auto opened = Try("right password");
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->token.size(), 64u);
  EXPECT_NE(opened->token, opened->session.id) << "the token is not kept";
  const auto found = log_ins_.Find(opened->token, now_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "anna");
  EXPECT_EQ(found->role, UserRole::kOperator);
  EXPECT_TRUE(log_ins_.At(found->id, now_));
  EXPECT_TRUE(log_ins_.IsHere("anna", now_));
  EXPECT_FALSE(log_ins_.Find(found->id, now_));
  EXPECT_FALSE(log_ins_.Find("", now_));
  EXPECT_NE(Try("right password")->token, opened->token);
  log_ins_.LogOut(found->id);
  EXPECT_FALSE(log_ins_.Find(opened->token, now_));
  EXPECT_FALSE(log_ins_.At(found->id, now_));
  EXPECT_THAT(log_ins_.TakeEnded(now_), testing::ElementsAre(found->id));
}

TEST_F(LogInsOfTwo, ASessionEndsWhenItIsIdleAndAfterItsWholeTime) {
  const std::string idle = Try("right password")->token;
  const std::string used = Try("another password", "bert")->token;
  const auto opened = now_;
  now_ += 29min;
  EXPECT_TRUE(log_ins_.Find(used, now_));
  now_ += 2min;
  EXPECT_FALSE(log_ins_.Find(idle, now_));
  EXPECT_EQ(log_ins_.TakeEnded(now_).size(), 1u);
  while (now_ < opened + 12h) {
    EXPECT_TRUE(log_ins_.Find(used, now_));
    now_ += 20min;
  }
  now_ = opened + 12h + 1s;
  EXPECT_EQ(log_ins_.TakeEnded(now_).size(), 1u) << "without a request of it, too";
  EXPECT_FALSE(log_ins_.Find(used, now_));
}

TEST_F(LogInsOfTwo, APageThatOnlyShowsTheShopStaysAndCommandsNothing) {
  const auto opened = Try("right password");
  now_ += 29min;
  EXPECT_TRUE(log_ins_.Find(opened->token, now_)) << "the page in view sends this";
  log_ins_.Act(opened->session.id, now_);
  now_ += 29min;
  EXPECT_EQ(log_ins_.Find(opened->token, now_)->role, UserRole::kOperator);
  now_ += 2min;
  const auto resting = log_ins_.Find(opened->token, now_);
  ASSERT_TRUE(resting);
  EXPECT_EQ(resting->role, UserRole::kObserver);
  EXPECT_TRUE(resting->rests);
  EXPECT_FALSE(log_ins_.IsHere("anna", now_)) << "is in charge of nothing any more";
  log_ins_.Act(opened->session.id, now_);
  EXPECT_TRUE(log_ins_.At(opened->session.id, now_)->rests) << "until the next log-in";
  EXPECT_THAT(log_ins_.TakeEnded(now_), testing::IsEmpty());
  const auto again = Try("right password");
  EXPECT_FALSE(log_ins_.At(again->session.id, now_)->rests);
}

TEST_F(LogInsOfTwo, AUserWhoIsRemovedOrChangedIsLoggedOut) {
  const std::string before = Try("right password")->token;
  const std::string other = Try("another password", "bert")->token;
  EXPECT_THAT(log_ins_.TakeEnded(now_), testing::IsEmpty());
  anna_.role = UserRole::kObserver;
  Write(anna_);
  std::filesystem::last_write_time(file_, std::filesystem::last_write_time(file_) + 1s);
  EXPECT_EQ(log_ins_.TakeEnded(now_).size(), 1u);
  EXPECT_FALSE(log_ins_.Find(before, now_));
  EXPECT_TRUE(log_ins_.Find(other, now_));
  std::filesystem::remove(file_);
  EXPECT_EQ(log_ins_.TakeEnded(now_).size(), 1u);
  EXPECT_FALSE(log_ins_.Find(other, now_));
}

TEST_F(LogInsOfTwo, TenWrongPasswordsSlowDown) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(WhyNot("wrong password"), ErrorCode::kRefused);
  EXPECT_EQ(WhyNot("right password"), ErrorCode::kTimedOut) << "it is not even checked";
  EXPECT_EQ(WhyNot("right password", "anna", "192.0.2.2"), ErrorCode::kTimedOut)
      << "whatever the address";
  EXPECT_EQ(WhyNot("another password", "bert"), ErrorCode::kTimedOut)
      << "whatever the name";
  EXPECT_TRUE(Try("another password", "bert", "192.0.2.2"));
  // Each further one doubles the time, to a minute.
  std::chrono::seconds wait = 1s;
  for (int i = 0; i < 9; ++i) {
    now_ += wait - 1ms;
    EXPECT_EQ(WhyNot("wrong password"), ErrorCode::kTimedOut) << wait.count();
    now_ += 1ms;
    EXPECT_EQ(WhyNot("wrong password"), ErrorCode::kRefused) << wait.count();
    wait = std::min<std::chrono::seconds>(2 * wait, 60s);
  }
  EXPECT_THAT(Try("right password").error().message, HasSubstr("wait 60 s"));
  now_ += 60s;
  EXPECT_TRUE(Try("right password"));
}

TEST_F(LogInsOfTwo, NoAnswerNamesAUser) {
  const auto nobody = Try("wrong password", "nobody");
  const auto wrong = Try("wrong password", "bert");
  ASSERT_FALSE(nobody);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(nobody.error().message, wrong.error().message);
  EXPECT_EQ(nobody.error().code, ErrorCode::kRefused);
}

TEST_F(LogInsOfTwo, AFileThatOthersCanReadIsNoWrongPassword) {
  std::filesystem::permissions(file_, std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(WhyNot("right password"), ErrorCode::kIo);
}

TEST_F(LogInsOfTwo, MoreSessionsThanAllowedEndTheOneThatWasUsedLongestAgo) {
  std::vector<std::string> tokens;
  for (int i = 0; i < 3; ++i) {
    tokens.push_back(Try("right password")->token);
    now_ += 1s;
  }
  EXPECT_TRUE(log_ins_.Find(tokens[0], now_));
  ASSERT_TRUE(Try("right password"));
  EXPECT_TRUE(log_ins_.Find(tokens[0], now_));
  EXPECT_FALSE(log_ins_.Find(tokens[1], now_));
}

}  // namespace
}  // namespace intaglio::access
