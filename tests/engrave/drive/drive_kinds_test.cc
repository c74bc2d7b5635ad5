#include "engrave/drive/drive_kinds.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"
#include "engrave/drive/first_order.h"
#include "engrave/drive/second_order.h"

namespace intaglio::drive {
namespace {

TEST(DriveKinds, EachRowMakesTheDriveOfItsName) {
  for (const DriveKind& kind : DriveKinds()) {
    std::vector<double> values;
    for (const DriveParameter& parameter : kind.parameters)
      values.push_back(parameter.max);
    const auto made = MakeDrive(kind.name, values);
    ASSERT_TRUE(made.has_value());
    EXPECT_EQ((*made)->name(), kind.name);
  }
}

TEST(DriveKinds, AnUnknownNameListsTheKnownOnes) {
  const auto made = MakeDrive("magnetic", {});
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(made.error().message,
            "drive magnetic: no such drive; known: first_order, second_order, servo, "
            "cascade, stepper_screw, planar_drive");
}

TEST(DriveKinds, TheNumberOfValuesIsChecked) {
  const double values[] = {100, 0.7, 1};
  for (const std::size_t count : {0, 1, 3}) {
    const auto made = MakeDrive("second_order", std::span(values).first(count));
    ASSERT_FALSE(made.has_value()) << count;
    EXPECT_EQ(made.error().code, ErrorCode::kInvalidValue);
  }
}

TEST(DriveKinds, MadeWithoutTheRegistryWrongValuesThrow) {
  EXPECT_THROW(FirstOrder(-1e-9), PreconditionError);
  EXPECT_THROW(SecondOrder(100, 0), PreconditionError);
  EXPECT_THROW(SecondOrder(0, 0.7), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drive
