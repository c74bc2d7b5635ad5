#include "services/console/shop_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

class Metrics : public ::testing::Test {
 protected:
  Metrics() {
    machine().set_cell("els-03");
    machine().set_laser_line_up(true);
    machine().set_motion_line_up(true);
  }
  MachineStatus& machine() {
    return shop_.machines_size() > 0 ? *shop_.mutable_machines(0) : *shop_.add_machines();
  }
  OpenJob& job() {
    if (shop_.jobs_size() == 0) shop_.add_jobs()->set_job(3);
    machine().set_job(3);
    return *shop_.mutable_jobs(0);
  }
  /// The shop is as it is now for this time.
  void Pass(std::chrono::milliseconds time) {
    metrics_.Follow(shop_, now_);
    now_ += time;
    metrics_.Follow(shop_, now_);
  }
  ShopStatus shop_;
  ShopMetrics metrics_;
  ShopMetrics::Clock::time_point now_{1h};
};

TEST_F(Metrics, EveryMomentOfAMachineHasOneUse) {
  Pass(1500ms);
  job().set_state("engraving");
  Pass(1s);
  Pass(250ms);
  job().set_alarm("no crack is seen");
  Pass(500ms);
  job().set_state("paused");
  job().set_pause_reason("interlock");
  Pass(750ms);
  machine().add_stops_held("intaglio-console");
  Pass(125ms);
  machine().set_laser_line_up(false);
  Pass(2s);
  const std::string text = metrics_.Text();
  const auto use = [](const std::string& name, const std::string& seconds) {
    return HasSubstr("intaglio_machine_seconds_total{machine=\"els-03\",use=\"" + name +
                     "\"} " + seconds + "\n");
  };
  EXPECT_THAT(text, use("idle", "1.5"));
  EXPECT_THAT(text, use("engraving", "1.25"));
  EXPECT_THAT(text, use("no_progress", "0.5"));
  EXPECT_THAT(text, use("paused_interlock", "0.75"));
  EXPECT_THAT(text, use("stopped", "0.125"));
  EXPECT_THAT(text, use("unknown", "2"));
}

TEST_F(Metrics, ALongGapCountsForNothing) {
  Pass(1s);
  Pass(1h);
  EXPECT_THAT(metrics_.Text(), HasSubstr("use=\"idle\"} 1\n"));
}

TEST_F(Metrics, CountPiecesAndJobsAndKeepNamesInTheirQuotes) {
  metrics_.CountPiece("els-03", "good");
  metrics_.CountPiece("els-03", "good");
  metrics_.CountPiece("a\"b\\c\nd", "");
  job().set_state("queued");
  shop_.add_needs("a person");
  Pass(1s);
  const std::string text = metrics_.Text();
  EXPECT_THAT(text, HasSubstr("machine=\"els-03\",verdict=\"good\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("machine=\"a\\\"b\\\\c\\nd\",verdict=\"none\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("\nintaglio_jobs{state=\"queued\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("\nintaglio_needs 1\n"));
  EXPECT_THAT(text, HasSubstr("\nintaglio_door_closed{machine=\"els-03\"} 0\n"));
  EXPECT_THAT(text, Not(HasSubstr("\n\n")));
}

}  // namespace
}  // namespace intaglio::console
