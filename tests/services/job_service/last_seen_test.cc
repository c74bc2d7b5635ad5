#include "services/job_service/last_seen.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class LastSeenTest : public testing::Test {
 protected:
  ~LastSeenTest() override { fs::remove(file_); }

  void Write(const std::string& boot, std::chrono::nanoseconds at) {
    std::ofstream(file_) << boot << ' ' << at.count() << '\n';
  }
  static std::string Boot() {
    std::string id;
    std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
    return id;
  }

  fs::path file_ = fs::path(testing::TempDir()) / ("seen-" + std::to_string(getpid()));
};

TEST_F(LastSeenTest, TheFirstOneKnowsOfNoOther) {
  EXPECT_FALSE(LastSeen(file_).absence().has_value());
}

TEST_F(LastSeenTest, TheNextOneKnowsForHowLongThereWasNone) {
  LastSeen(file_).Note();
  const auto absence = LastSeen(file_).absence();
  ASSERT_TRUE(absence.has_value());
  EXPECT_GE(*absence, 0ns);
  EXPECT_LT(*absence, 60s);
}

TEST_F(LastSeenTest, AnotherBootOrNonsenseIsNotKnown) {
  for (const auto& [boot, at] :
       {std::pair<std::string, std::chrono::nanoseconds>{"another-boot", 5s},
        {Boot(), std::chrono::nanoseconds(INT64_MAX)},
        {"", 5s}}) {
    Write(boot, at);
    EXPECT_FALSE(LastSeen(file_).absence().has_value()) << boot;
  }
}

TEST_F(LastSeenTest, ADiskThatRefusesHoldsNothingUp) {
  LastSeen seen("/nonexistent/folder/seen");
  seen.Note();
  EXPECT_FALSE(seen.absence().has_value());
}

}  // namespace
}  // namespace intaglio::job_service
