// What a reader that acknowledges nothing, or is stopped, does to who writes to it: the
// synchronizer's loop writes its pulse events, and a permission to fire is worth 90 ms.

#include <gtest/gtest.h>
#include <signal.h>

#include <map>
#include <thread>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::bus {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::ChildProgram;
using test::Eventually;
using test::PrivateBusOptions;
using test::PrivateTag;

class Unacknowledged : public ::testing::Test {
 protected:
  struct Times {
    double max_ms = 0, sum_ms = 0;
    int failed = 0;
  };

  bool Write() {
    const std::vector<std::uint64_t> tick(64, 1);
    const std::vector<std::uint32_t> point(64, 1);
    const std::vector<std::uint8_t> outcome(64, 0);
    intaglio_PulseEventBatch batch{};
    batch.job_uid = Borrow(job_);
    batch.sequence_number = static_cast<std::uint64_t>(written_);
    Borrow(batch.tick, tick);
    Borrow(batch.point, point);
    Borrow(batch.outcome, outcome);
    Borrow(batch.reason, outcome);
    ++written_;
    return writer_.Write(batch).has_value();
  }
  /// One in 5 ms: a synchronizer writes one in 20 ms.
  Times WriteFor(std::chrono::milliseconds duration) {
    Times times;
    for (const auto end = Clock::now() + duration; Clock::now() < end;) {
      const auto begin = Clock::now();
      if (!Write()) ++times.failed;
      const double ms =
          std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
      times.max_ms = std::max(times.max_ms, ms);
      times.sum_ms += ms;
      std::this_thread::sleep_for(5ms);
    }
    std::printf("  the longest write took %.2f ms, all %.1f ms; %d failed\n",
                times.max_ms, times.sum_ms, times.failed);
    return times;
  }
  /// The counts that `count` and `deaf` report about themselves.
  int CountOf(const std::string& instance) {
    health_.Take([this](const intaglio_ServiceHealth& health) {
      counts_[std::string(View(health.instance))] = health.pid;
    });
    return counts_[instance];
  }
  /// Longer than any write of a machine at rest, shorter than a permission's lease.
  static void ExpectUndisturbed(const Times& times) {
    EXPECT_EQ(times.failed, 0);
    EXPECT_LT(times.max_ms, 50);
  }

  const std::string job_ = "1-1";
  Bus bus_{PrivateBusOptions("els-03")};
  Writer<intaglio_PulseEventBatch> writer_{bus_, kPulseEventBatch};
  Reader<intaglio_ServiceHealth> health_{bus_, kServiceHealth};
  std::map<std::string, int> counts_;
  int written_ = 0;
};

TEST_F(Unacknowledged, ALivingReaderThatAcknowledgesNothingHoldsNobodyUp) {
  ChildProgram good(INTAGLIO_BUS_PEER, {PrivateTag(), "count", "good"});
  ASSERT_TRUE(Eventually([this] { return writer_.matched_count() == 1; }));
  ChildProgram deaf(INTAGLIO_BUS_PEER, {PrivateTag(), "deaf", "deaf"});
  ASSERT_TRUE(Eventually([this] { return writer_.matched_count() == 2; }));
  ASSERT_TRUE(Eventually([this] { return Write() && CountOf("deaf") > 0; }));
  std::this_thread::sleep_for(100ms);  // then it is deaf
  ExpectUndisturbed(WriteFor(5s));
  EXPECT_EQ(writer_.matched_count(), 2);  // it lived all the time
  EXPECT_EQ(writer_.WaitForAcknowledgements(0ms).has_value(), false);
  // Who does acknowledge has every one of them.
  EXPECT_TRUE(Eventually([this] { return CountOf("good") == written_; }))
      << CountOf("good") << " of " << written_;
}

TEST_F(Unacknowledged, AStoppedReaderHoldsNobodyUp) {
  ChildProgram stopped(INTAGLIO_BUS_PEER, {PrivateTag(), "count", "stopped"});
  ASSERT_TRUE(Eventually([this] { return Write() && CountOf("stopped") > 0; }));
  stopped.Signal(SIGSTOP);
  ExpectUndisturbed(WriteFor(3s));
  stopped.Signal(SIGCONT);
}

}  // namespace
}  // namespace intaglio::bus
