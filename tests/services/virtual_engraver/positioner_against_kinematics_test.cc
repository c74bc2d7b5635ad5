// The positioner of the virtual engraver and the kinematics of the services share no
// code: at the axes that one has for a place, the other has to have the focus there.

#include <gtest/gtest.h>

#include <string>

#include "engrave/machine/kinematics.h"
#include "tests/services/virtual_engraver/positioner_text.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr double kRoundingMm = 1e-9;

std::string GuideOf(int bits) {
  return std::string((bits & 2) != 0 ? "-" : "") + ((bits & 1) != 0 ? "block" : "head");
}

machine::LinearAxis AxisOf(int bits) { return {(bits & 1) != 0, (bits & 2) != 0}; }

double Off(const machine::Kinematics& kinematics, const std::string& positioner,
           const Vec3& place_mm) {
  const auto axes = kinematics.ToAxes(place_mm, Vec3(5, 0, 0));
  EXPECT_TRUE(axes) << axes.error().message;
  return (FocusAt(PositionerOf(positioner), *axes) - place_mm).norm();
}

TEST(PositionerAgainstKinematics, EveryLinearArrangementAgrees) {
  const Vec3 place_mm(31, -7, 12);
  for (int bits = 0; bits < 64; ++bits) {
    const auto kinematics = machine::MakeKinematics(
        machine::CartesianOptions{AxisOf(bits), AxisOf(bits >> 2), AxisOf(bits >> 4)});
    const std::string same =
        GuideOf(bits) + "," + GuideOf(bits >> 2) + "," + GuideOf(bits >> 4);
    EXPECT_LT(Off(*kinematics, same, place_mm), kRoundingMm) << same;
    const int other = bits ^ 1;  // x carries the other part
    const std::string wrong =
        GuideOf(other) + "," + GuideOf(bits >> 2) + "," + GuideOf(bits >> 4);
    EXPECT_NEAR(Off(*kinematics, wrong, place_mm), 62, kRoundingMm) << "the mirror image";
  }
}

// Guides that are longer or shorter than they count, y turned: the corrections of the
// kinematics, whichever part an axis carries.
TEST(PositionerAgainstKinematics, CorrectionsAgree) {
  const Vec3 place_mm(31, -7, 12);
  for (int bits = 0; bits < 64; ++bits) {
    machine::CartesianOptions options{AxisOf(bits), AxisOf(bits >> 2), AxisOf(bits >> 4)};
    options.x.scale_ratio = 1.0005;
    options.y.scale_ratio = 0.999;
    options.z.scale_ratio = 1.01;
    options.squareness_xy_rad = 0.0007;
    PositionerOptions truth =
        PositionerOf(GuideOf(bits) + "," + GuideOf(bits >> 2) + "," + GuideOf(bits >> 4));
    truth.guides[0].travel_ratio = 1.0005;
    truth.guides[1].travel_ratio = 0.999;
    truth.guides[1].turn_rad =
        -0.0007;  // its + towards that of x: less than a right angle
    truth.guides[2].travel_ratio = 1.01;
    const auto axes = machine::MakeKinematics(options)->ToAxes(place_mm, {});
    ASSERT_TRUE(axes);
    EXPECT_LT((FocusAt(truth, *axes) - place_mm).norm(), kRoundingMm) << bits;
    truth.guides[1].turn_rad = 0.0007;
    EXPECT_GT((FocusAt(truth, *axes) - place_mm).norm(), 0.009);
  }
}

TEST(PositionerAgainstKinematics, ArmAndTableAgreeOnBothSides) {
  for (const auto side : {machine::ArmSide::kLeft, machine::ArmSide::kRight}) {
    machine::PolarOptions options;
    options.side = side;
    options.z = {true, false};
    const auto kinematics = machine::MakeKinematics(options);
    for (double x_mm = -50; x_mm <= 50; x_mm += 5) {
      for (double y_mm = 70; y_mm <= 180; y_mm += 5) {
        const Vec3 place_mm(x_mm, y_mm, 11);
        EXPECT_LT(Off(*kinematics, "arm,200,150,block", place_mm), kRoundingMm);
        EXPECT_GT(Off(*kinematics, "arm,200,149,block", place_mm), 0.5);
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
