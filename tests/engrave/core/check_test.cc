#include "engrave/core/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio {
namespace {

TEST(Require, PassesWhenTheConditionHolds) {
  EXPECT_NO_THROW(Require(true, "never said {}", 1));
}

TEST(Require, ThrowsWithTheValues) {
  try {
    Require(false, "spacing_mm must be positive, is {}", -0.5);
    FAIL() << "did not throw";
  } catch (const PreconditionError& error) {
    EXPECT_STREQ(error.what(), "spacing_mm must be positive, is -0.5");
  }
}

TEST(Require, IsALogicErrorSoThatAServiceCatchesItAtItsLoop) {
  EXPECT_THROW(Require(false, "broken"), std::logic_error);
}

}  // namespace
}  // namespace intaglio
