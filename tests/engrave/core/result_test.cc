#include "engrave/core/result.h"

#include <gtest/gtest.h>

#include <set>

namespace intaglio {
namespace {

Result<int> Half(int value) {
  if (value % 2 != 0) {
    return Fail(ErrorCode::kInvalidValue, "value must be even", std::to_string(value));
  }
  return value / 2;
}

Status OnlyEven(int value) {
  if (auto half = Half(value); !half) return tl::unexpected(half.error());
  return {};
}

TEST(Result, CarriesTheValue) { EXPECT_EQ(Half(8).value(), 4); }

TEST(Result, CarriesCodeSentenceAndOffendingValue) {
  const auto result = Half(7);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidValue);
  EXPECT_EQ(result.error().message, "value must be even");
  EXPECT_EQ(result.error().value, "7");
}

TEST(Status, PassesAnErrorOn) {
  EXPECT_TRUE(OnlyEven(2).has_value());
  EXPECT_EQ(OnlyEven(3).error().value, "3");
}

TEST(ErrorCode, EveryCodeHasANameOfItsOwn) {
  std::set<std::string> names;
  // kCancelled is the last enumerator.
  for (int code = 0; code <= static_cast<int>(ErrorCode::kCancelled); ++code) {
    const std::string name = ErrorCodeName(static_cast<ErrorCode>(code));
    EXPECT_NE(name, "unknown") << code;
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

}  // namespace
}  // namespace intaglio
