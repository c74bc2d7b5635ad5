#include "engrave/sort/order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

using ::testing::HasSubstr;

OrderOptions With(Method method) {
  OrderOptions options;
  options.method = method;
  options.anneal.tries_per_point = 1;
  return options;
}

constexpr Method kAll[] = {Method::kKdz,    Method::kLayers,        Method::kSmooth,
                           Method::kAnneal, Method::kBoustrophedon, Method::kPublishedKdz,
                           Method::kSweep};

TEST(MakeOrder, NamesEveryPointOnceAndAlwaysTheSame) {
  for (const Method method : kAll) {
    for (const auto& [name, points_mm] : Clouds(2000)) {
      const Order order = MakeOrder(points_mm, With(method)).value();
      Order sorted = order;
      std::sort(sorted.begin(), sorted.end());
      ASSERT_EQ(sorted.size(), points_mm.size());
      for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i) << name;
      EXPECT_EQ(MakeOrder(points_mm, With(method)).value(), order) << name;
    }
    EXPECT_TRUE(MakeOrder({}, With(method)).value().empty());
  }
}

TEST(MakeOrder, RefusesOptionsOutsideTheirRange) {
  const PointList points_mm = RandomBox(10, {1, 1, 1}, 1);
  for (const double up_ratio : {-0.1, 100.1, std::nan("")}) {
    OrderOptions options = With(Method::kKdz);
    options.kdz.up_ratio = up_ratio;
    const auto order = MakeOrder(points_mm, options);
    ASSERT_FALSE(order.has_value());
    EXPECT_EQ(order.error().code, ErrorCode::kInvalidValue);
    EXPECT_THAT(order.error().message, HasSubstr("kdz.up_ratio"));
    EXPECT_THAT(order.error().message, HasSubstr("0..100"));
  }
  for (const double thickness_mm : {0.0, 0.0099, 100.1, std::nan("")}) {
    OrderOptions options = With(Method::kLayers);
    options.layers.layer_thickness_mm = thickness_mm;
    const auto order = MakeOrder(points_mm, options);
    ASSERT_FALSE(order.has_value());
    EXPECT_THAT(order.error().message, HasSubstr("0.01..100"));
  }
  OrderOptions other_method_wrong = With(Method::kKdz);
  other_method_wrong.layers.layer_thickness_mm = -1;
  EXPECT_TRUE(MakeOrder(points_mm, other_method_wrong).has_value());
}

TEST(MakeOrder, RefusesPointsThatAreNotFinite) {
  PointList points_mm = RandomBox(10, {1, 1, 1}, 1);
  points_mm[7].y() = std::nan("");
  for (const Method method : kAll) {
    const auto order = MakeOrder(points_mm, With(method));
    ASSERT_FALSE(order.has_value());
    EXPECT_THAT(order.error().message, HasSubstr("point 7 is not finite"));
  }
}

TEST(MakeOrder, TakesPointsWithinAKilometreAndRefusesOthers) {
  PointList points_mm = RandomBox(10, {1, 1, 1}, 1);
  for (const Method method : kAll) {
    for (const double far_mm : {1e6, -1e6}) {
      points_mm[7] = {0, far_mm, 0};
      EXPECT_TRUE(MakeOrder(points_mm, With(method)).has_value());
    }
    for (const double far_mm : {1.1e6, -1e30, 1e300}) {
      points_mm[7] = {0, 0, far_mm};
      const auto order = MakeOrder(points_mm, With(method));
      ASSERT_FALSE(order.has_value());
      EXPECT_EQ(order.error().code, ErrorCode::kInvalidValue);
      EXPECT_THAT(order.error().message, HasSubstr("point 7 is too far away"));
    }
  }
}

TEST(MakeOrder, EndsEarlyWhenAsked) {
  const PointList points_mm = RandomBox(100, {1, 1, 1}, 1);
  for (const Method method : kAll) {
    const auto order =
        MakeOrder(points_mm, With(method), [](std::uint64_t, std::uint64_t total) {
          EXPECT_EQ(total, 100);
          return false;
        });
    ASSERT_FALSE(order.has_value());
    EXPECT_EQ(order.error().code, ErrorCode::kCancelled);
  }
}

}  // namespace
}  // namespace intaglio::sort
