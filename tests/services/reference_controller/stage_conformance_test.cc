// The reference controller keeps every guarantee of a motion controller, over a
// pseudo-terminal, with the edges of its steps as the judge of what moved.

#include <gtest/gtest.h>

#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/reference_controller/stage_rig.h"

namespace intaglio::reference_controller {
namespace {

class ReferenceStage : public ::testing::TestWithParam<drivers::MotionCheck> {};

TEST_P(ReferenceStage, Keeps) {
  EXPECT_EQ(drivers::ViolationOf(GetParam(),
                                 [](const std::string& serial_number) {
                                   return std::make_unique<StageRig>(serial_number);
                                 }),
            "");
}

INSTANTIATE_TEST_SUITE_P(Of, ReferenceStage,
                         ::testing::ValuesIn(drivers::MotionChecks().begin(),
                                             drivers::MotionChecks().end()),
                         [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace intaglio::reference_controller
