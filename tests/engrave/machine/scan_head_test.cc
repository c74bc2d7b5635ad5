#include "engrave/machine/scan_head.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engrave/machine/axes_from_glass.h"
#include "engrave/optics/focus.h"

namespace intaglio::machine {
namespace {

constexpr double kIndex = 1.519473;

/// A cube of 60 mm, its middle under a lens of f = 100 mm with its pupil 140 mm away.
AxesFromGlass HeadOverCube(const ScanHeadOptions& of_head = {}, double aperture = 1e-9) {
  optics::MachineFromGlass frame{Vec3(-30, -30, 2), Vec3::Constant(60),
                                 optics::StagePerGlassRatio(kIndex, aperture)};
  ScanHeadOptions head = of_head;
  if (head.lens.is_telecentric()) head.lens.pupil_mm = {140, 140};
  head.refractive_index = kIndex;
  head.top_z_mm = frame.top_z_mm();
  return {frame, MakeKinematics(head)};
}

Vec3 AxesAt(const AxesFromGlass& axes_from_glass, const Vec3& glass_mm) {
  const auto axes = axes_from_glass.ToAxes(glass_mm, Vec3::Zero());
  EXPECT_TRUE(axes) << (axes ? "" : axes.error().message);
  return axes.value_or(Vec3::Zero());
}

// 25, 25 mm from the axis and 55 mm deep: u = 24.888718 mm, h = 34.939237 mm, of another
// program (tests/engrave/optics/oblique_focus_test.cc).
TEST(ScanHead, PutsTheFocusInTheGlass) {
  const Vec3 axes = AxesAt(HeadOverCube(), Vec3(55, 55, 5));
  EXPECT_NEAR(axes.x(), 24.888718, 3e-6);
  EXPECT_NEAR(axes.y(), 24.888718, 3e-6);
  EXPECT_NEAR(axes.z(), 62 - 34.939237, 2e-5);  // the index has six decimals
  EXPECT_LT((HeadOverCube().ToGlass(axes) - Vec3(55, 55, 5)).norm(), 1e-9);
}

// z on its steps, the focus where it belongs in x and y, and within half a step of z,
// which is 0.05 mm of glass under the axis and a little more beside it.
TEST(ScanHead, RestsOnTheStepsOfZ) {
  ScanHeadOptions options;
  options.z_step_mm = 0.066;
  const AxesFromGlass head = HeadOverCube(options), exact = HeadOverCube();
  double farthest_mm = 0;
  for (const Vec3& place : {Vec3(55, 55, 5), Vec3(30, 30, 20.01), Vec3(7, 40, 55.3),
                            Vec3(5.5, 54, 31.234), Vec3(30, 12, 59.99)}) {
    const Vec3 axes = AxesAt(head, place);
    EXPECT_NEAR(axes.z() / 0.066, std::round(axes.z() / 0.066), 1e-9);
    EXPECT_LE(std::abs(axes.z() - AxesAt(exact, place).z()), 0.033 + 1e-9);
    const Vec3 focus = head.ToGlass(axes);
    EXPECT_LT((focus - place).head<2>().norm(), 1e-9);
    farthest_mm = std::max(farthest_mm, std::abs(focus.z() - place.z()));
  }
  EXPECT_LT(farthest_mm, 0.054);
  EXPECT_GT(farthest_mm, 0.01);
}

TEST(ScanHead, UprightBeamsMoveAsUnderAStage) {
  const AxesFromGlass head = HeadOverCube({}, 0.05);
  const Vec3 axes = AxesAt(head, Vec3(30, 30, 10));
  EXPECT_EQ(axes.head<2>(), Vec2::Zero());
  EXPECT_NEAR(axes.z(), head.machine_from_glass().ToMachine(Vec3(30, 30, 10)).z(), 1e-12);
}

struct TracedRay {
  Vec3 at_face_mm, way;  // z down
};

/// By Snell's law in vectors, of a ray that is aimed at `aim_mm` below the face.
TracedRay Traced(const Vec3& aim_mm, const Vec3& way_in_air) {
  const double cosine = way_in_air.z(), ratio = 1 / kIndex;
  const double inside = std::sqrt(1 - ratio * ratio * (1 - cosine * cosine));
  Vec3 way = ratio * way_in_air;
  way.z() += inside - ratio * cosine;
  return {aim_mm - aim_mm.z() / cosine * way_in_air, way};
}

/// The point of `ray` that is nearest to the line of `chief`.
Vec3 NearestTo(const TracedRay& chief, const TracedRay& ray) {
  const Vec3 normal = chief.way.cross(ray.way).cross(chief.way);
  return ray.at_face_mm +
         normal.dot(chief.at_face_mm - ray.at_face_mm) / normal.dot(ray.way) * ray.way;
}

/// The middle of both line foci, where rays in the plane of incidence and rays beside it
/// come nearest to the chief ray: a point of the glass, from its position of the axes.
/// The lens is 140 mm from its pupil.
Vec3 TracedPoint(const Vec3& axes, double aperture) {
  const Vec3 aim_mm(axes.x(), axes.y(), 62 - axes.z());
  const Vec3 chief = Vec3(axes.x() / 140, axes.y() / 140, 1).normalized();
  const Vec3 across = chief.cross(Vec3::UnitZ());
  const Vec3 beside = across.norm() > 0 ? Vec3(across.normalized()) : Vec3(Vec3::UnitX());
  const Vec3 outward = chief.cross(beside);
  Vec3 sum_mm = Vec3::Zero();
  for (const Vec3& side : {beside, Vec3(-beside), outward, Vec3(-outward)}) {
    const Vec3 way = std::sqrt(1 - aperture * aperture) * chief + aperture * side;
    sum_mm += NearestTo(Traced(aim_mm, chief), Traced(aim_mm, way));
  }
  const Vec3 middle_mm = sum_mm / 4;
  return {middle_mm.x() + 30, middle_mm.y() + 30, 60 - middle_mm.z()};
}

// A pencil of 1e-4: a whole ring has its narrowest place up to 15 um from the middle.
TEST(ScanHead, PutsTheFocusOfATracedBeamOnThePoint) {
  for (const double x : {1.0, 18.0, 30.0, 41.0, 59.0}) {
    for (const double y : {2.0, 27.0, 58.0}) {
      for (const double z : {1.0, 25.0, 55.0}) {
        const Vec3 point_mm(x, y, z);
        const Vec3 wrong_mm =
            TracedPoint(AxesAt(HeadOverCube(), point_mm), 1e-4) - point_mm;
        EXPECT_LT(wrong_mm.head<2>().norm(), 1e-3) << point_mm.transpose();
        EXPECT_LT(std::abs(wrong_mm.z()), 2e-3) << point_mm.transpose();
      }
    }
  }
}

// The marginal rays of a beam of NA 0.03: their coma and the change of the spherical
// aberration with the angle are not in the pencil.
TEST(ScanHead, AWideBeamIsOffByItsAberrationsAlone) {
  for (const double x : {30.0, 41.0, 55.0}) {
    const Vec3 point_mm(x, 38, 5);
    const Vec3 wrong_mm =
        TracedPoint(AxesAt(HeadOverCube({}, 0.03), point_mm), 0.03) - point_mm;
    EXPECT_LT(wrong_mm.head<2>().norm(), 0.008) << point_mm.transpose();
    EXPECT_LT(std::abs(wrong_mm.z()), 0.008) << point_mm.transpose();
  }
}

// At 35 mm off the axis the same depth needs the plane 0.5 mm higher than in the middle.
TEST(ScanHead, ALayerOfTheGlassIsNoLayerOfTheAxis) {
  const AxesFromGlass head = HeadOverCube();
  const double middle_mm = AxesAt(head, Vec3(30, 30, 10)).z();
  EXPECT_GT(AxesAt(head, Vec3(59, 59, 10)).z() - middle_mm, 0.5);
}

TEST(ScanHead, ATelecentricLensNeedsOnlyTheDepth) {
  ScanHeadOptions straight;
  straight.refractive_index = kIndex;
  const auto kinematics = MakeScanHead(straight);
  for (const Vec3& place_mm : {Vec3(20, -7, -40), Vec3(0, 0, 0), Vec3(-35, 35, 3)})
    EXPECT_LT((kinematics->ToAxes(place_mm, {}).value() - place_mm).norm(), 1e-12);
}

TEST(ScanHead, MirrorsAreCommandedWithTheCorrection) {
  galvo::FieldGrid grid = galvo::CentredGrid(80, 5);
  for (Vec2& value_mm : grid.values_mm) value_mm = {0.5, -0.25};
  ScanHeadOptions corrected;
  corrected.corrections = std::make_shared<galvo::CorrectionTable>(
      galvo::CorrectionTable::Make(grid, galvo::Interpolation::kBilinear).value());
  const Vec3 glass_mm(47, 21, 33);
  const Vec3 by_mm =
      AxesAt(HeadOverCube(corrected), glass_mm) - AxesAt(HeadOverCube(), glass_mm);
  EXPECT_LT((by_mm - Vec3(0.5, -0.25, 0)).norm(), 1e-9);
}

TEST(ScanHead, RefusesOptionsOutOfRange) {
  const auto refused = [](const ScanHeadOptions& options) {
    EXPECT_THROW(MakeScanHead(options), std::logic_error);
  };
  ScanHeadOptions options;
  options.lens.pupil_mm = {0, 140};
  refused(options);
  options = {};
  options.refractive_index = 0.9;
  refused(options);
}

}  // namespace
}  // namespace intaglio::machine
