// The reference controller keeps every guarantee of a laser controller, over a
// pseudo-terminal, with the outputs as the judge of what fired.

#include <gtest/gtest.h>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/reference_controller/reference_rig.h"

namespace intaglio::reference_controller {
namespace {

class ReferenceController : public ::testing::TestWithParam<drivers::LaserCheck> {};

TEST_P(ReferenceController, Keeps) {
  EXPECT_EQ(drivers::ViolationOf(GetParam(),
                                 [](const std::string& serial_number) {
                                   return std::make_unique<ReferenceRig>(serial_number);
                                 }),
            "");
}

INSTANTIATE_TEST_SUITE_P(Of, ReferenceController,
                         ::testing::ValuesIn(drivers::LaserChecks().begin(),
                                             drivers::LaserChecks().end()),
                         [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace intaglio::reference_controller
