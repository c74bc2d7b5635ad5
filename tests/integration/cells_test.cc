// A shop with several virtual machines by one command: all are found, a job on one of
// them leaves the others alone, and nothing runs when the shop is closed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "engrave/formats/glass_record.h"
#include "services/client/shop/shop_snapshot.h"
#include "services/platform/bus/bus.h"
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

class Cells : public ::testing::Test {
 protected:
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", "43", "--tag", tag_});
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words),
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  void Open(const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "up",         "--folder",  shop_, "--materials", folder_ / "materials.db",
        "--lockstep", "--warm-up", "0",   "--block",     "50",
        "50",         "30"};
    words.insert(words.end(), more.begin(), more.end());
    up_ = std::make_unique<Running>(Program("intaglio"), With(words), folder_ / "up.txt");
    ASSERT_TRUE(Eventually(
        [this] {
          return !up_->running() ||
                 up_->Output().find("the shop is open") != std::string::npos;
        },
        60s));
    ASSERT_TRUE(up_->running()) << up_->Output();
  }
  static std::size_t CracksOf(const fs::path& cell) {
    const auto record = formats::ReadGlassRecord(cell / "glass.rec");
    return record ? record->cracks.size() : 0;
  }

  const fs::path folder_ = test::FreshFolder(), shop_ = folder_ / "shop";
  const std::string tag_ = "cells" + std::to_string(getpid());
  std::unique_ptr<Running> up_;
  int typed_ = 0;
};

TEST_F(Cells, ThreeAreFoundAndAJobOnOneLeavesTheOthersAlone) {
  ASSERT_NO_FATAL_FAILURE(Open({"--cells", "3", "--virtual"}));
  const auto services = testing::ProcessesWith({"intaglio-", tag_});
  EXPECT_EQ(services.size(), 3u + 3 * 2);
  EXPECT_EQ(testing::ProcessesWith({"virtual-engraver", shop_.string()}).size(), 3u);

  const Ended status = Type({"status"});
  EXPECT_EQ(status.exit_code, 0) << status.output;
  EXPECT_THAT(status.output, HasSubstr("all is well"));
  for (const char* cell : {"els-03 ", "els-03-2", "els-03-3"}) {
    EXPECT_THAT(status.output, HasSubstr(std::string("machine    ") + cell));
    EXPECT_THAT(status.output, HasSubstr(std::string("mounted    ") + cell));
  }

  const fs::path second = shop_ / "cells/els-03-2";
  const Ended made =
      Type({"submit", INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--height",
            "6", "--machine", second / "machine.textproto", "--arm", "--watch"});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  EXPECT_THAT(Type({"show", "1"}).output, HasSubstr("els-03-2"));

  // No other machine has fired a pulse.
  for (const fs::path& other : {shop_, shop_ / "cells/els-03-3"}) {
    EXPECT_THAT(testing::AskPanel(other, "status"), HasSubstr("\"pulses\": 0"));
  }
  // No service was lost or started again meanwhile.
  EXPECT_EQ(testing::ProcessesWith({"intaglio-", tag_}), services);
  EXPECT_THAT(Type({"status"}).output, HasSubstr("all is well"));

  up_->Signal(SIGINT);
  const Ended ended = up_->WaitForEnd(30s);
  EXPECT_TRUE(ended.in_time);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(testing::ProcessesWith({tag_}).size(), 0u);
  EXPECT_EQ(testing::ProcessesWith({shop_.string()}).size(), 0u);
  // The folder of the job is complete, with the glass of its machine.
  const fs::path job = *fs::directory_iterator(shop_ / "jobs");
  const std::string report = testing::TextIn(job / "report.json");
  EXPECT_THAT(report, HasSubstr("\"evidence\": \"glass\""));
  EXPECT_THAT(report, HasSubstr("\"kind\": \"good\""));
  EXPECT_GT(CracksOf(second), 0u);
  EXPECT_EQ(CracksOf(shop_), 0u);
  EXPECT_EQ(CracksOf(shop_ / "cells/els-03-3"), 0u);
}

// A client that the job service alone answers sees every machine, and discovers none:
// the work of a client of N machines does not grow with what 3 N participants announce.
TEST_F(Cells, AreShownByWhatTheJobServiceKnowsAndAMachineThatIsGoneIsNot) {
  ASSERT_NO_FATAL_FAILURE(Open({"--cells", "2", "--virtual"}));
  bus::BusOptions options;
  options.control_domain = 43;
  options.tag = tag_;
  options.meets_cells = false;
  bus::Bus bus(options);
  client::ShopWatcher shop(bus);
  const auto becomes = [&](const auto& condition) {
    return Eventually(
        [&] {
          shop.Poll(20ms);
          return condition();
        },
        30s);
  };
  ASSERT_TRUE(becomes([&] { return shop.IsComplete(); }));
  const client::ShopSnapshot open = shop.Take();
  EXPECT_EQ(open.services.size(), 3u + 2 * 2);
  for (const char* cell : {"els-03", "els-03-2"}) {
    ASSERT_TRUE(open.cells.contains(cell));
    EXPECT_TRUE(open.cells.at(cell).laser_line_up && open.cells.at(cell).has_motion);
  }
  for (const client::ServiceView& discovered : shop.client().services())
    EXPECT_EQ(discovered.cell.find("els-03-2"), std::string::npos) << discovered.instance;

  // A stopped process answers as little as a killed one, and nobody starts it again.
  const auto bridges =
      testing::ProcessesWith({"intaglio-motion-bridge", "els-03-2", tag_});
  ASSERT_EQ(bridges.size(), 1u);
  ASSERT_EQ(kill(bridges[0], SIGSTOP), 0);
  const auto has_bridge = [&] {
    return std::ranges::any_of(shop.Take().services, [](const auto& service) {
      return service.cell == "els-03-2" && service.role == intaglio_ROLE_MOTION_BRIDGE;
    });
  };
  EXPECT_TRUE(becomes([&] { return !has_bridge(); }));
  EXPECT_FALSE(shop.Take().cells.at("els-03-2").has_motion);
  EXPECT_THAT(Type({"status"}).output, HasSubstr("els-03-2: no motion-bridge runs"));
  ASSERT_EQ(kill(bridges[0], SIGCONT), 0);
  EXPECT_TRUE(becomes([&] { return has_bridge() && shop.IsComplete(); }));

  // Without a job service the machines are asked.
  const auto job_services = testing::ProcessesWith({"intaglio-job-service", tag_});
  ASSERT_EQ(job_services.size(), 1u);
  ASSERT_EQ(kill(job_services[0], SIGSTOP), 0);
  EXPECT_TRUE(becomes([&] { return shop.Take().services.empty(); }));
  const Ended met = Type({"status"});
  EXPECT_THAT(met.output, AllOf(HasSubstr("no job-service runs"),
                                HasSubstr("machine    els-03-2   lamp")));
  ASSERT_EQ(kill(job_services[0], SIGCONT), 0);
}

// The remedy of a refused arm is a command for this machine, and not for another one.
TEST_F(Cells, ABlockIsReportedAtTheMachineThatTheRemedyNames) {
  ASSERT_NO_FATAL_FAILURE(Open({"--cells", "2", "--virtual"}));
  const Ended submitted =
      Type({"submit", INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--height",
            "6", "--block", "60", "55", "20", "--machine",
            shop_ / "cells/els-03-2/machine.textproto"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
  const Ended refused = Type({"arm", "1"});
  EXPECT_EQ(refused.exit_code, 4) << refused.output;
  EXPECT_THAT(refused.output,
              HasSubstr("`intaglio mount --machine els-03-2 --block 60 55 20`"));
  const Ended mounted =
      Type({"mount", "--machine", "els-03-2", "--block", "60", "55", "20"});
  EXPECT_EQ(mounted.exit_code, 0) << mounted.output;
  EXPECT_THAT(mounted.output, HasSubstr("els-03-2: 60 x 55 x 20"));
  EXPECT_THAT(Type({"status"}).output,
              AllOf(HasSubstr("mounted    els-03     50 x 50 x 30"),
                    HasSubstr("mounted    els-03-2   60 x 55 x 20")));
  EXPECT_EQ(Type({"arm", "1"}).exit_code, 0);
  // A name that no machine of the shop has is refused.
  EXPECT_EQ(
      Type({"mount", "--machine", "els-03-9", "--block", "60", "55", "20"}).exit_code, 2);
  up_->Signal(SIGINT);
  EXPECT_EQ(up_->WaitForEnd(30s).exit_code, 0);
}

TEST_F(Cells, AShopWithOneOfTheirNamesIsRefused) {
  ASSERT_NO_FATAL_FAILURE(Open({"--cells", "2", "--virtual"}));
  const Ended second =
      Type({"up", "--folder", folder_ / "other", "--materials", folder_ / "materials.db",
            "--machine", shop_ / "cells/els-03-2/machine.textproto", "--without",
            "job-service", "discretizer", "sorter"});
  EXPECT_EQ(second.exit_code, 2) << second.output;
  EXPECT_THAT(second.output, HasSubstr("already runs"));
  EXPECT_FALSE(fs::exists(folder_ / "other"));
  up_->Signal(SIGINT);
  EXPECT_EQ(up_->WaitForEnd(30s).exit_code, 0);
}

TEST_F(Cells, OfARealMachineThereIsOneAProfile) {
  const Ended refused = Type({"up", "--folder", shop_, "--cells", "2"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.output, HasSubstr("--virtual"));
  EXPECT_EQ(Type({"up", "--folder", shop_, "--virtual", "--real-machine"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(shop_));
}

}  // namespace
}  // namespace intaglio
