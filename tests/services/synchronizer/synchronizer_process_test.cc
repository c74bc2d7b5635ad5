// intaglio-synchronizer as a process, between the bus and a virtual engraver.

#include <gtest/gtest.h>

#include <optional>

#include "services/bus/bus.h"
#include "services/bus/samples.h"
#include "tests/services/bus/private_bus.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/services/virtual_engraver/taken_line.h"

namespace intaglio::synchronizer {
namespace {

using intaglio::testing::Running;
using test::Eventually;
using namespace std::chrono_literals;

const std::string kCell = "els-03";

class SynchronizerProcess : public ::testing::Test {
 protected:
  SynchronizerProcess()
      : folder_(intaglio::testing::FreshFolder(
            std::string("synchronizer_") +
            ::testing::UnitTest::GetInstance()->current_test_info()->name())),
        engraver_(folder_, {}),
        bus_(test::PrivateBusOptions(kCell)),
        interlocks_(bus_, bus::kInterlock, kCell) {}

  void SetUp() override {
    ASSERT_TRUE(engraver_.AwaitReady()) << engraver_.program().Output();
  }
  std::unique_ptr<Running> Start(const std::string& log) {
    return std::make_unique<Running>(
        intaglio::testing::Program("intaglio-synchronizer"),
        std::vector<std::string>{"--machine",
                                 INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto",
                                 "--device", engraver_.laser_line(), "--tag",
                                 test::PrivateTag(), "--cell", kCell},
        folder_ / log);
  }
  bool LineIsUp() {
    bool up = false;
    return Eventually([&] {
      interlocks_.Take([&](const intaglio_Interlock& s) { up = s.laser_link_up; });
      return up;
    });
  }

  std::filesystem::path folder_;
  virtual_engraver::EngraverProcess engraver_;
  bus::Bus bus_;
  bus::Reader<intaglio_Interlock> interlocks_;
};

TEST_F(SynchronizerProcess, WhoseLaserIsTakenOverEndsWithAFault) {
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(virtual_engraver::TakeLineOver(engraver_.laser_line()));
  const auto ended = synchronizer->WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_NE(ended.output.find(
                "another synchronizer has taken this machine over; this process ends"),
            std::string::npos)
      << ended.output;
}

}  // namespace
}  // namespace intaglio::synchronizer
