// The positioner of the virtual engraver and the kinematics of the services share no
// code: at the axes that one has for a place, the other has to have the focus there.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engrave/machine/axes_from_glass.h"
#include "engrave/machine/kinematics.h"
#include "engrave/optics/focus.h"
#include "engrave/optics/oblique_intensity.h"
#include "services/virtual_engraver/beam.h"
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

/// Where the traced beam of the virtual engraver meets, for the axes that the kinematics
/// has for a point of a cube of 60 mm under the middle of the field.
Vec3 MetAt(const Vec3& point_mm, const machine::ScanHeadOptions& head, double aperture,
           double distortion_ratio = 0) {
  BlockInMachine block{Vec3(-30, -30, 2), Vec3::Constant(60), head.refractive_index,
                       aperture};
  const optics::MachineFromGlass frame{
      block.origin_mm, block.size_mm,
      optics::StagePerGlassRatio(block.refractive_index, aperture)};
  const auto axes =
      machine::AxesFromGlass(frame, machine::MakeKinematics(head)).ToAxes(point_mm, {});
  EXPECT_TRUE(axes);
  PositionerOptions truth;
  truth.has_mirrors = true;
  truth.pupil_mm = {140, 135};
  truth.distortion_ratio = distortion_ratio;
  return TraceFocus(FocusAt(truth, *axes), block, BeamSlopes(truth, *axes)).position_mm;
}

machine::ScanHeadOptions HeadOverCube() {
  machine::ScanHeadOptions head;
  head.lens.pupil_mm = {140, 135};
  head.refractive_index = 1.519473;
  head.top_z_mm = 62;
  return head;
}

// A cube of 50 mm, 5 to 55 mm deep; marginal rays of NA 0.03 have 6 um of coma.
TEST(PositionerAgainstKinematics, MirrorsPutTracedBeamsOnThePoints) {
  for (double x_mm = 5; x_mm <= 55; x_mm += 12.5) {
    for (double y_mm = 5; y_mm <= 55; y_mm += 12.5) {
      for (double z_mm = 5; z_mm <= 55; z_mm += 25) {
        const Vec3 point_mm(x_mm, y_mm, z_mm);
        const Vec3 wrong_mm = MetAt(point_mm, HeadOverCube(), 0.03) - point_mm;
        EXPECT_LT(wrong_mm.head<2>().norm(), 0.010) << point_mm.transpose();
        EXPECT_LT(std::abs(wrong_mm.z()), 0.015) << point_mm.transpose();
      }
    }
  }
}

// With each correction switched off: without the pupil the beam is taken for upright, 2
// mm too high; without the lens's distortion in the commands the point is aside.
TEST(PositionerAgainstKinematics, MirrorsMissWithoutTheirCorrections) {
  machine::ScanHeadOptions upright = HeadOverCube();
  upright.lens = {};
  const Vec3 corner_mm(55, 55, 5);
  const Vec3 wrong_mm = MetAt(corner_mm, upright, 0.03) - corner_mm;
  EXPECT_NEAR(wrong_mm.z(), -2.07, 0.05);
  EXPECT_NEAR(wrong_mm.head<2>().norm(), 0.171, 0.01);
  // 0.02 of (35.4 mm / 100 mm)^2 of 35.4 mm.
  const Vec3 distorted_mm = MetAt(corner_mm, HeadOverCube(), 0.03, 0.02) - corner_mm;
  EXPECT_NEAR(distorted_mm.head<2>().norm(), 0.088, 0.005);
}

TEST(PositionerAgainstKinematics, ObliqueBeamsLoseAsTheSumOfPlaneWaves) {
  const BlockInMachine block{Vec3::Zero(), Vec3::Constant(100), 1.519473, 0.03};
  for (const double tangent : {0.02, 0.07, 0.105, 0.14, 0.176, 0.25}) {
    for (const double depth_mm : {30.0, 60.0}) {
      const Vec3 aim_mm(20, 20, 100 - depth_mm / 1.53);
      const Focus focus = TraceFocus(aim_mm, block, Vec2(0, tangent));
      const double traced = PeakLeft(block, focus.apart_mm, 0.532e-3);
      const double summed = optics::ObliquePeakRatio({0.532e-3, 0.03, 1.519473}, tangent,
                                                     100 - focus.position_mm.z());
      EXPECT_NEAR(traced, summed, 0.06) << tangent << " " << depth_mm;
    }
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
