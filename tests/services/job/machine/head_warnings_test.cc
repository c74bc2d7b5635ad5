#include "services/job/machine/head_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

namespace intaglio {
namespace {

using testing::HasSubstr;

std::vector<Error> WarningsWith(const std::function<void(ScanHead&)>& change) {
  MachineSpec machine;
  machine.mutable_mark_line()->set_protocol("scan-head");
  ScanHead& head = *machine.mutable_scan_head();
  head.set_servo_lag_s(0.0002);
  head.set_lead_servo(false);
  head.set_run_in_s(0);
  change(head);
  return HeadWarningsOf(machine);
}

// galvo_proof_test has what such a head burns.
TEST(HeadWarnings, AHeadThatBurnsTheEndOfItsJumpsIsWarnedOf) {
  const auto found = WarningsWith([](ScanHead&) {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message, HasSubstr("scan_head.run_in_s: 0"));
  EXPECT_THAT(found[0].message, HasSubstr("0.0002 s behind"));
  EXPECT_THAT(found[0].message, HasSubstr("of 0.0006 s or more"));
}

TEST(HeadWarnings, OneThatWaitsOrLeadsIsNot) {
  EXPECT_TRUE(WarningsWith([](ScanHead& h) { h.set_jump_delay_s(0.003); }).empty());
  EXPECT_TRUE(WarningsWith([](ScanHead& h) { h.set_run_in_s(0.0006); }).empty());
  EXPECT_TRUE(WarningsWith([](ScanHead& h) { h.clear_run_in_s(); }).empty());
  EXPECT_TRUE(WarningsWith([](ScanHead& h) { h.clear_lead_servo(); }).empty());
  EXPECT_TRUE(WarningsWith([](ScanHead& h) { h.clear_servo_lag_s(); }).empty());
  EXPECT_TRUE(HeadWarningsOf(MachineSpec()).empty());
}

TEST(HeadWarnings, ABoardsAxisThatNobodyHasMeasuredIsWarnedOf) {
  MachineSpec machine;
  machine.mutable_motion_line()->set_protocol("bjjcz");
  machine.mutable_head_over_block();
  const auto found = HeadWarningsOf(machine);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message, HasSubstr("head_over_block.z.scale_ratio: is missing"));
  EXPECT_THAT(found[0].message, HasSubstr("intaglio teach jog z 10"));
  machine.mutable_head_over_block()->mutable_z()->set_scale_ratio(1);
  EXPECT_TRUE(HeadWarningsOf(machine).empty());
  machine.mutable_head_over_block()->clear_z();
  machine.mutable_motion_line()->set_protocol("linuxcnc");
  EXPECT_TRUE(HeadWarningsOf(machine).empty());
}

}  // namespace
}  // namespace intaglio
