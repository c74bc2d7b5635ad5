#include "services/job/machine/position_tolerance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio {
namespace {

using ::testing::HasSubstr;

TEST(PositionTolerance, AMismatchNamesBothAndItsEffect) {
  const std::string smaller = ToleranceMismatch(10, 30);
  EXPECT_THAT(smaller, HasSubstr("controller is 10 um and that of the profile 30 um"));
  EXPECT_THAT(smaller, HasSubstr("pulses between the two are held back"));
  EXPECT_THAT(smaller, HasSubstr("position_tolerance_um"));
  EXPECT_THAT(ToleranceMismatch(30, 10), HasSubstr("farther from their place"));
}

TEST(PositionTolerance, WhatAgreesOrIsNotKnownIsNoMismatch) {
  EXPECT_EQ(ToleranceMismatch(30, 30), "");
  EXPECT_EQ(ToleranceMismatch(29.9, 30), "");
  EXPECT_EQ(ToleranceMismatch(0, 30), "");
  EXPECT_EQ(ToleranceMismatch(30, 0), "");
}

}  // namespace
}  // namespace intaglio
