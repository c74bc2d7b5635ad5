#include "engrave/core/try.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace intaglio {
namespace {

Result<int> HalfOf(int value) {
  if (value % 2 == 0) return value / 2;
  return Fail(ErrorCode::kInvalidValue, "give an even number", std::to_string(value));
}

Status CheckHalf(int value) {
  INTAGLIO_TRY(HalfOf(value));
  return {};
}

Result<std::unique_ptr<int>> Quarter(int value) {
  const int half = INTAGLIO_TRY(HalfOf(value));
  return std::make_unique<int>(INTAGLIO_TRY(HalfOf(half)));
}

Result<int> QuarterByPointer(int value) {
  const std::unique_ptr<int> quarter = INTAGLIO_TRY(Quarter(value));
  INTAGLIO_TRY(CheckHalf(*quarter * 2));
  return *quarter;
}

TEST(Try, GivesTheValue) { EXPECT_EQ(QuarterByPointer(12), 3); }

TEST(Try, ReturnsTheErrorWithEverythingInIt) {
  const auto first = QuarterByPointer(7), second = QuarterByPointer(6);
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().code, ErrorCode::kInvalidValue);
  EXPECT_EQ(first.error().message, "give an even number");
  EXPECT_EQ(first.error().value, "7");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().value, "3");
  EXPECT_FALSE(CheckHalf(5));
  EXPECT_TRUE(CheckHalf(4));
}

// What was made before the error is destroyed.
TEST(Try, LeavesNothingBehind) {
  const auto kept = std::make_shared<int>(1);
  const auto holds = [](std::shared_ptr<int> held, int value) -> Result<int> {
    const int half = INTAGLIO_TRY(HalfOf(value));
    return half + *held;
  };
  EXPECT_FALSE(holds(kept, 3));
  EXPECT_EQ(kept.use_count(), 1);
  EXPECT_EQ(holds(kept, 4), 3);
}

TEST(Try, ALambdaInTheExpressionMayTryItself) {
  const auto run = []() -> Result<int> {
    const auto call = [](const auto& f) -> Result<int> { return f(8); };
    return INTAGLIO_TRY(call([](int v) -> Result<int> {
      const int half = INTAGLIO_TRY(HalfOf(v));
      return half;
    }));
  };
  EXPECT_EQ(run(), 4);
}

}  // namespace
}  // namespace intaglio
