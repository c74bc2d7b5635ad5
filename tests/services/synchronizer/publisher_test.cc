#include "services/synchronizer/publisher.h"

#include <gtest/gtest.h>

#include "tests/patience.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

class PublishedLamp : public testing::Test {
 protected:
  /// The samples of so much time, with a tick every 5 ms.
  std::vector<intaglio_LampSync> SamplesOf(std::chrono::milliseconds time) {
    std::vector<intaglio_LampSync> samples;
    for (const auto end = bench_.now + time; bench_.now < end;) {
      if (bench_.now % 5ms == 0ns) bench_.PassTicks(1);
      bench_.Step();
      publisher_.PublishLaser(bench_.controller, stop_, bench_.now);
      lamp_.Take([&](const intaglio_LampSync& sample) { samples.push_back(sample); });
    }
    return samples;
  }

  LaserBench bench_;
  host::StopLatch stop_;
  bus::Bus bus_{test::PrivateBusOptions("els-03")};
  Publisher publisher_{bus_, "els-03", "synchronizer-1"};
  bus::Reader<intaglio_LampSync> lamp_{bus_, bus::kLampSync, "els-03"};
};

TEST_F(PublishedLamp, IsRepeatedTenTimesASecondWhileOnlyTicksPass) {
  bench_.WarmUp();
  const auto before = SamplesOf(200ms);
  ASSERT_FALSE(before.empty());
  const auto samples = SamplesOf(1s);
  EXPECT_LE(samples.size(), 11u);
  ASSERT_FALSE(samples.empty());
  EXPECT_GT(samples.back().tick, before.back().tick);
}

TEST_F(PublishedLamp, IsPublishedWithTheFirstStatusThatDiffers) {
  bench_.WarmUp();
  (void)SamplesOf(200ms);
  ASSERT_TRUE(bench_.controller.Lamp(false, 0));
  auto samples = SamplesOf(45ms);  // a status comes every 20 ms
  // A busy computer delivers the sample later.
  EXPECT_TRUE(test::Eventually([&] {
    lamp_.Take([&](const intaglio_LampSync& sample) { samples.push_back(sample); });
    return !samples.empty() && samples.back().warm_ratio == 0;
  }));
}

}  // namespace
}  // namespace intaglio::synchronizer
