// Whole jobs beside a participant with a valid identity who abuses it: an observer that
// acknowledges nothing, one that is stopped now and then, a stage worker that forges. The
// job ends well, in real time, without a pause; no service has left the bus or ended
// before.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <regex>
#include <thread>

#include "services/platform/bus/identity.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;

constexpr char kAbusedJob[] = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto";
constexpr char kPublishedMachine[] =
    INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";

class SecuredAbuse : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!bus::SecurityConfiguration({folder_, {}, {}})) {
      GTEST_SKIP() << "the DDS library is here without its security plugins";
    }
    setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
    unsetenv("INTAGLIO_SECURITY");
    Running made(Program("intaglio"), {"security", "new", keys_.string()},
                 folder_ / "made.txt");
    ASSERT_EQ(made.WaitForEnd(60s).exit_code, 0) << made.Output();
    // The published machine, whose lamp is warm sooner.
    const std::string profile = testing::TextIn(kPublishedMachine);
    std::ofstream(machine_) << std::regex_replace(
        profile, std::regex("warm_up_s: [0-9.]+"), "warm_up_s: 1");
  }

  static std::string Tag() { return "abuse" + std::to_string(getpid()); }
  std::unique_ptr<Running> Stranger(const std::string& role,
                                    const std::string& deed) const {
    return std::make_unique<Running>(
        fs::path(INTAGLIO_STRANGER),
        std::vector<std::string>{Tag(), (keys_ / role).string(), deed, "-", "els-03"},
        folder_ / (deed + ".txt"));
  }
  std::unique_ptr<Running> Run() const {
    return std::make_unique<Running>(
        Program("intaglio"),
        std::vector<std::string>{"run", kAbusedJob, "--height", "5", "--machine",
                                 machine_.string(), "--tag", Tag(), "--security",
                                 keys_.string(), "--out", (folder_ / "out").string()},
        folder_ / "run.txt");
  }
  std::string Logs() const {
    std::string all;
    for (const auto& file : fs::recursive_directory_iterator(folder_ / "out")) {
      if (file.path().extension() == ".log") all += testing::TextIn(file.path());
    }
    return all;
  }
  void ExpectGoodAndUndisturbed(Running& run) {
    const Ended ended = run.WaitForEnd(150s);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    const std::string logs = Logs();
    EXPECT_NE(logs, "");
    for (const char* disturbance : {"leaves the domain", "second_instance", "was lost",
                                    "does not answer", "attempt 2", "pauses", "paused"}) {
      EXPECT_THAT(logs, Not(HasSubstr(disturbance)));
    }
    std::cout << "  ended after " << ended.seconds << " s\n";
  }

  fs::path folder_ = test::FreshFolder();
  fs::path keys_ = folder_ / "keys", machine_ = folder_ / "machine.textproto";
};

TEST_F(SecuredAbuse, AnObserverThatAcknowledgesNothingDisturbsNobody) {
  const auto deaf = Stranger("observer", "deaf");
  const auto run = Run();
  ASSERT_TRUE(
      Eventually([&] { return deaf->Output().find("deaf") != std::string::npos; }, 60s))
      << deaf->Output();
  ExpectGoodAndUndisturbed(*run);
  EXPECT_TRUE(deaf->running());
}

TEST_F(SecuredAbuse, AnObserverThatIsStoppedNowAndThenDisturbsNobody) {
  const auto observer = Stranger("observer", "look");
  const auto run = Run();
  ASSERT_TRUE(Eventually(
      [&] { return observer->Output().find("looks") != std::string::npos; }, 60s))
      << observer->Output();
  while (run->running()) {
    observer->Signal(SIGSTOP);
    std::this_thread::sleep_for(1500ms);  // within a lease, and then beyond it
    observer->Signal(SIGCONT);
    std::this_thread::sleep_for(500ms);
    observer->Signal(SIGSTOP);
    std::this_thread::sleep_for(3500ms);
    observer->Signal(SIGCONT);
    std::this_thread::sleep_for(500ms);
  }
  ExpectGoodAndUndisturbed(*run);
}

TEST_F(SecuredAbuse, AStageWorkerThatForgesDisturbsNobody) {
  const auto forger = Stranger("stage-worker", "forge");
  ASSERT_TRUE(Eventually(
      [&] { return forger->Output().find("forges\n") != std::string::npos; }, 60s))
      << forger->Output();
  const auto run = Run();
  ExpectGoodAndUndisturbed(*run);
  // It was there, knew whom to name, and its library refused it the partitions of others.
  EXPECT_THAT(forger->Output(), HasSubstr("forges the engraving of"));
  EXPECT_THAT(forger->Output(), HasSubstr("health of job-service refused"));
  EXPECT_THAT(forger->Output(), HasSubstr("health of cell-els-03 refused"));
  EXPECT_TRUE(forger->running());
}

}  // namespace
}  // namespace intaglio
