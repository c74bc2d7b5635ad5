#include "services/client/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "services/platform/command_line/other_programs.h"
#include "tests/patience.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

class ChildProcessTest : public ::testing::Test {
 protected:
  Result<ChildProcess> Shell(const std::string& script) {
    return ChildProcess::Start({"shell", "/bin/sh", {"-c", script}, output_});
  }
  static bool Exists(pid_t pid) { return kill(pid, 0) == 0; }
  static bool AwaitOutput(const ChildProcess& child, const std::string& text) {
    return test::Eventually(
        [&] { return child.LastOutput().find(text) != std::string::npos; }, 5s);
  }

  fs::path output_ = test::FreshFolder() / "output";
};

TEST_F(ChildProcessTest, KeepsItsOutputAndItsExitCode) {
  auto child = Shell("echo out; echo err >&2; exit 7");
  ASSERT_TRUE(child) << child.error().message;
  EXPECT_EQ(child->name(), "shell");
  ASSERT_TRUE(child->WaitForEnd(5s));
  EXPECT_FALSE(child->running());
  EXPECT_EQ(child->exit_code(), 7);
  EXPECT_EQ(child->LastOutput(), "out\nerr\n");
  EXPECT_EQ(child->LastOutput(4), "err\n");
}

TEST_F(ChildProcessTest, RunsInAProcessGroupOfItsOwn) {
  // Ctrl-C on the terminal must reach the command, which ends its children in order.
  const auto child = Shell("exec sleep 60");
  ASSERT_TRUE(child);
  EXPECT_EQ(getpgid(child->pid()), child->pid());
  EXPECT_NE(getpgid(child->pid()), getpgid(0));
}

TEST_F(ChildProcessTest, IsEndedByItsIdAndReportsTheSignal) {
  auto child = Shell("exec sleep 60");
  ASSERT_TRUE(child);
  EXPECT_TRUE(child->running());
  EXPECT_EQ(child->exit_code(), std::nullopt);
  EXPECT_FALSE(child->WaitForEnd(20ms)) << "it has a minute to go";
  child->Terminate();
  ASSERT_TRUE(child->WaitForEnd(5s));
  EXPECT_EQ(child->exit_code(), 128 + SIGTERM);
}

TEST_F(ChildProcessTest, DoesNotOutliveItsOwner) {
  pid_t pid = -1;
  {
    const auto child = Shell("exec sleep 60");
    ASSERT_TRUE(child);
    pid = child->pid();
    EXPECT_TRUE(Exists(pid));
  }
  EXPECT_FALSE(Exists(pid));
}

// Takes the three seconds that a process has to end by itself.
TEST_F(ChildProcessTest, ThatIgnoresTheFriendlySignalIsKilled) {
  pid_t pid = -1;
  {
    const auto child = Shell("trap '' TERM; echo ready; while :; do sleep 0.1; done");
    ASSERT_TRUE(child);
    ASSERT_TRUE(AwaitOutput(*child, "ready"));
    pid = child->pid();
  }
  EXPECT_FALSE(Exists(pid));
}

TEST_F(ChildProcessTest, ThatIsReplacedEndsTheOldOne) {
  auto first = Shell("exec sleep 60");
  auto second = Shell("exec sleep 60");
  ASSERT_TRUE(first && second);
  const pid_t old_pid = first->pid(), new_pid = second->pid();
  *first = std::move(*second);
  EXPECT_FALSE(Exists(old_pid));
  EXPECT_EQ(first->pid(), new_pid);
  EXPECT_TRUE(first->running());
}

TEST_F(ChildProcessTest, ThatIsNotThereIsNamed) {
  const auto child = ChildProcess::Start({"sorter", "/no/such/sorter", {}, output_});
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(child.error().message, HasSubstr("/no/such/sorter"));
}

TEST(ProgramFolder, IsWhereThisProgramLies) {
  EXPECT_TRUE(fs::exists(command_line::ProgramFolder() / "cli_test"));
}

}  // namespace
}  // namespace intaglio::client
