// The programs of which there is one: a second ends before it touches anything.

#include "services/platform/host/process/only_instance.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <memory>

#include "tests/integration/run_program.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/test_folder.h"

namespace intaglio::host {
namespace {

using intaglio::testing::Running;
using test::Eventually;
using namespace std::chrono_literals;

struct Single {
  std::string program;
  std::string name;
};

class OnlyOne : public ::testing::TestWithParam<Single> {
 protected:
  OnlyOne()
      : folder_(test::FreshFolder()),
        bus_(test::PrivateBusOptions()),
        health_(bus_, bus::kServiceHealth) {}

  /// Its line is nowhere; that is a fault it can have for as long as it likes.
  std::unique_ptr<Running> Start(const std::string& cell = "els-03") {
    std::vector<std::string> arguments = {"--tag", tag_, "--cell", cell};
    const auto add = [&](const std::string& name, const std::string& value) {
      arguments.push_back(name);
      arguments.push_back(value);
    };
    if (GetParam().program == "intaglio-job-service") {
      add("--database", folder_ / "jobs.db");
      add("--results", folder_ / "jobs");
    } else {
      add("--machine", INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
      add("--device", folder_ / "no_line");
    }
    return std::make_unique<Running>(intaglio::testing::Program(GetParam().program),
                                     arguments,
                                     folder_ / fmt::format("{}.log", ++started_));
  }
  bool Works(const Running& program) {
    bool works = false;
    return Eventually([&] {
      health_.Take([&](const intaglio_ServiceHealth& s) {
        works = works || (s.pid == program.pid() && s.state != intaglio_HEALTH_STARTING &&
                          s.state != intaglio_HEALTH_STOPPING);
      });
      return works;
    });
  }

  const std::string tag_ = test::PrivateTag();
  std::filesystem::path folder_;
  bus::Bus bus_;
  bus::Reader<intaglio_ServiceHealth> health_;
  int started_ = 0;
};

TEST_P(OnlyOne, ASecondReportsWhoIsThereAndEnds) {
  const auto first = Start();
  ASSERT_TRUE(Works(*first)) << first->Output();
  const auto ended = Start()->WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, kExitSecond);
  EXPECT_NE(
      ended.output.find(fmt::format("is served by another {} on ", GetParam().name)),
      std::string::npos)
      << ended.output;
  EXPECT_NE(ended.output.find(fmt::format("process {}", first->pid())), std::string::npos)
      << ended.output;
  EXPECT_TRUE(first->running());
}

TEST_P(OnlyOne, OfThreeThatStartAtOnceOneStays) {
  std::vector<std::unique_ptr<Running>> three;
  for (int i = 0; i < 3; ++i) three.push_back(Start());
  const auto running_count = [&] {
    return std::count_if(three.begin(), three.end(),
                         [](const auto& program) { return program->running(); });
  };
  EXPECT_TRUE(Eventually([&] { return running_count() == 1; }, 5s));
  std::this_thread::sleep_for(500ms);  // the last one does not go, too
  EXPECT_EQ(running_count(), 1);
  for (const auto& program : three) {
    if (program->running()) continue;
    EXPECT_EQ(program->WaitForEnd(1s).exit_code, kExitSecond);
  }
}

// The last sample of the killed process is still there when the next one starts.
TEST_P(OnlyOne, TheNextOneComesUpAfterAKill) {
  auto first = Start();
  ASSERT_TRUE(Works(*first)) << first->Output();
  const auto next = Start();
  first->Signal(SIGKILL);
  if (!Eventually([&] { return !next->running(); }, 1s)) {
    EXPECT_TRUE(Works(*next)) << next->Output();
    return;
  }
  // Two of its samples were received before it died: the next one comes up.
  const auto third = Start();
  EXPECT_TRUE(Works(*third)) << third->Output();
}

// A child of a test has a base of its own, whatever the folders of the user are.
TEST_P(OnlyOne, OpensNoMaterialBaseOfTheUser) {
  const auto user = folder_ / "user";
  setenv("XDG_DATA_HOME", user.c_str(), 1);
  const auto program = Start();
  unsetenv("XDG_DATA_HOME");
  ASSERT_TRUE(Works(*program)) << program->Output();
  EXPECT_FALSE(std::filesystem::exists(user));
  if (GetParam().program != "intaglio-job-service") return;
  const char* own = std::getenv("INTAGLIO_MATERIALS_DB");
  ASSERT_NE(own, nullptr);
  EXPECT_TRUE(std::string(own).starts_with(INTAGLIO_TEST_DIR)) << own;
  EXPECT_TRUE(std::filesystem::exists(own)) << own;
}

INSTANTIATE_TEST_SUITE_P(
    Programs, OnlyOne,
    ::testing::Values(Single{"intaglio-synchronizer", "synchronizer"},
                      Single{"intaglio-motion-bridge", "motion bridge"},
                      Single{"intaglio-job-service", "job service"}),
    [](const auto& tested) {
      std::string name = tested.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

}  // namespace
}  // namespace intaglio::host
