#include "services/job_service/last_seen.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "services/job_service/boot_clock.h"
#include "tests/test_folder.h"

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
  NotePlace Place() {
    return {[this] { return test::ContentOf(file_); },
            [this](const std::string& text) { std::ofstream(file_) << text; }};
  }
  static std::string Boot() {
    std::string id;
    std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
    return id;
  }

  fs::path file_ = fs::path(testing::TempDir()) / ("seen-" + std::to_string(getpid()));
};

TEST_F(LastSeenTest, TheFirstOneKnowsOfNoOther) {
  EXPECT_FALSE(LastSeen(Place()).absence().has_value());
}

TEST_F(LastSeenTest, TheNextOneKnowsForHowLongThereWasNone) {
  LastSeen(Place()).Note();
  const auto absence = LastSeen(Place()).absence();
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
    EXPECT_FALSE(LastSeen(Place()).absence().has_value()) << boot;
  }
}

// 25 s away, a second there, 25 s away: a person may have changed the block.
TEST_F(LastSeenTest, AbsencesAreAddedUpOverLives) {
  const auto now = SinceBoot();
  const auto write = [&](std::chrono::nanoseconds there_for) {
    std::ofstream(file_) << Boot() << ' ' << (now - 25s).count() << ' '
                         << (now - 25s - there_for).count() << ' '
                         << std::chrono::nanoseconds(25s).count() << '\n';
  };
  write(1s);
  for (int life = 0; life < 3; ++life) {
    LastSeen seen(Place());
    ASSERT_TRUE(seen.absence().has_value());
    EXPECT_GE(*seen.absence(), 50s) << life;
    EXPECT_LT(*seen.absence(), 55s) << life;
    seen.Note();
  }
  write(30s);
  EXPECT_LT(*LastSeen(Place()).absence(), 30s) << "it was there for long enough";
}

TEST_F(LastSeenTest, ANonsensicalSumIsNotKnown) {
  const auto at = SinceBoot() - 1s;
  for (const auto& [since, sum] :
       {std::pair<std::int64_t, std::int64_t>{at.count() + 1, 0},
        {INT64_MIN, 0},
        {0, -1},
        {0, INT64_MAX}}) {
    std::ofstream(file_) << Boot() << ' ' << at.count() << ' ' << since << ' ' << sum;
    EXPECT_FALSE(LastSeen(Place()).absence().has_value()) << since << ' ' << sum;
  }
}

// Another computer's clock says nothing here: what stood by counts by its own.
TEST_F(LastSeenTest, AnotherComputersAbsenceIsMeasuredByTheStandby) {
  const auto now = SinceBoot();
  const std::string note = "another-boot " + std::to_string((900h).count()) + " 0 0\n";
  std::ofstream(file_) << note;
  EXPECT_FALSE(LastSeen(Place()).absence().has_value());
  std::ofstream(file_) << note;
  EXPECT_FALSE(LastSeen(Place(), SeenByStandby{"older", now - 3s}).absence().has_value());
  std::ofstream(file_) << note;
  const auto absence = LastSeen(Place(), SeenByStandby{note, now - 3s}).absence();
  ASSERT_TRUE(absence.has_value());
  EXPECT_GE(*absence, 3s);
  EXPECT_LT(*absence, 20s);
}

// 25 s away there, and as long until the one that stood by has taken over here.
TEST_F(LastSeenTest, AbsencesAreAddedUpOverComputers) {
  const auto now = SinceBoot();
  const std::chrono::nanoseconds there = 5000h, sum = 25s;
  const std::string note = "another-boot " + std::to_string(there.count()) + ' ' +
                           std::to_string((there - 1s).count()) + ' ' +
                           std::to_string(sum.count()) + '\n';
  std::ofstream(file_) << note;
  const auto absence = LastSeen(Place(), SeenByStandby{note, now - 25s}).absence();
  ASSERT_TRUE(absence.has_value());
  EXPECT_GE(*absence, 50s);
}

}  // namespace
}  // namespace intaglio::job_service
