#include "services/reference_controller/edge_record.h"

#include <gtest/gtest.h>

#include <chrono>

#include "engrave/core/check.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;

TEST(EdgeRecord, HasALineForEachEdgeBeforeTheNextOne) {
  const auto file = test::FreshFolder() / "edges.csv";
  auto record = EdgeRecord::Create(file);
  ASSERT_TRUE(record.has_value());
  record->Add({Output::kShutter3, true, 1500ns});
  EXPECT_EQ(testing::TextIn(file), "ns,output,on\n1500,shutters[2],1\n");
  record->Add({Output::kQSwitch, false, 2us});
  EXPECT_EQ(testing::TextIn(file), "ns,output,on\n1500,shutters[2],1\n2000,q_switch,0\n");
  EXPECT_FALSE(EdgeRecord::Create("/nowhere/edges.csv").has_value());
}

// By hand: 1, 2, 3, 6 have the mean 3 and the squares 4, 1, 0, 9.
TEST(Jitter, IsTheSpreadOfPeriodDelayAndWidth) {
  const Spread spread = SpreadOf({3, 1, 6, 2});
  EXPECT_EQ(spread.count, 4u);
  EXPECT_DOUBLE_EQ(spread.mean_us, 3);
  EXPECT_DOUBLE_EQ(spread.deviation_us, std::sqrt(14.0 / 4));
  EXPECT_EQ(spread.min_us, 1);
  EXPECT_EQ(spread.max_us, 6);
  EXPECT_THROW(SpreadOf({}), PreconditionError);
  const Jitter jitter = JitterOf({{Output::kLampTrigger, true, 0us},
                                  {Output::kQSwitch, true, 5us},
                                  {Output::kQSwitch, false, 125us},
                                  {Output::kLampTrigger, false, 130us},
                                  {Output::kLampTrigger, true, 10000us},
                                  {Output::kLampTrigger, false, 10100us},
                                  {Output::kLampTrigger, true, 20002us},
                                  {Output::kQSwitch, true, 20009us},
                                  {Output::kQSwitch, false, 20130us}});
  EXPECT_DOUBLE_EQ(jitter.period.mean_us, 10001);
  EXPECT_DOUBLE_EQ(jitter.delay.min_us, 5);
  EXPECT_DOUBLE_EQ(jitter.delay.max_us, 7);
  EXPECT_DOUBLE_EQ(jitter.width.max_us, 121);
  EXPECT_EQ(jitter.withheld, 1u);
}

}  // namespace
}  // namespace intaglio::reference_controller
