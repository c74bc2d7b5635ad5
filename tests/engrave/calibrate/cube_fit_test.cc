// A head with known errors makes the cube: its beams are traced through a tilted face by
// the vector form of Snell's law, which shares nothing with the fit.

#include "engrave/calibrate/cube_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "engrave/calibrate/cube_pattern.h"

namespace intaglio::calibrate {
namespace {

using ::testing::ElementsAre;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct TrueHead {
  double x_ratio = 1.013, y_ratio = 0.985, x_turn = 0.004, y_turn = 0.0015;
  Vec2 pupil_mm = {148, 131};
  double z_ratio = 1.02, index = 1.519473;
  double rise_x = 0.003, rise_y = -0.002;  // of the face, as angles
  Vec2 lean = {0.002, 0.0045};
  Vec3 origin_mm = {-30.4, -29.7, 0.8};  // of the block's corner
  double block_mm = 60;
};

/// The direction behind the face, for a unit direction and a unit normal against it.
Vec3 Refracted(const Vec3& direction, const Vec3& normal, double index) {
  const Vec3 along = (direction - direction.dot(normal) * normal) / index;
  return along - std::sqrt(1 - along.squaredNorm()) * normal;
}

struct Ray {
  Vec3 at_mm, direction;
};

/// The point of `chief` that is nearest to a ray beside it.
Vec3 MeetingPoint(const Ray& chief, const Ray& beside) {
  Eigen::Matrix<double, 3, 2> way;
  way << chief.direction, -beside.direction;
  const Vec3 apart_mm = beside.at_mm - chief.at_mm;
  const Vec2 lengths = way.colPivHouseholderQr().solve(apart_mm);
  return chief.at_mm + lengths[0] * chief.direction;
}

/// Where the head puts the mark in the frame of the block, mm.
Vec3 Traced(const TrueHead& head, const Vec2& field_mm, double z_mm) {
  // The block stands turned about its corner: x by the rise along x, y by that along y.
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(-head.rise_x, Vec3::UnitY()) *
                                Eigen::AngleAxisd(head.rise_y, Vec3::UnitX()))
                                   .toRotationMatrix();
  const Vec3 normal = turn.col(2);
  const Vec3 face_mm = head.origin_mm + head.block_mm * normal;
  const Vec2 commanded_mm(head.x_ratio * std::cos(head.x_turn) * field_mm.x() -
                              head.y_ratio * std::sin(head.y_turn) * field_mm.y(),
                          head.x_ratio * std::sin(head.x_turn) * field_mm.x() +
                              head.y_ratio * std::cos(head.y_turn) * field_mm.y());
  const double height_mm = head.z_ratio * z_mm;
  // Lean is counted from the face on the axis of the lens.
  const double top_mm = face_mm.dot(normal) / normal.z();
  Vec3 focus_mm;
  focus_mm << commanded_mm + head.lean * (height_mm - top_mm), height_mm;
  const Vec3 down =
      Vec3(commanded_mm.x() / head.pupil_mm.x(), commanded_mm.y() / head.pupil_mm.y(), -1)
          .normalized();
  const auto ray = [&](const Vec3& direction) {
    const double way = (face_mm - focus_mm).dot(normal) / direction.dot(normal);
    return Ray{focus_mm + way * direction, Refracted(direction, normal, head.index)};
  };
  const Vec3 sagittal = down.cross(normal).norm() > 1e-9
                            ? Vec3(down.cross(normal).normalized())
                            : Vec3::UnitX();
  const Vec3 tangential = sagittal.cross(down).normalized();
  const Ray chief = ray(down);
  constexpr double kBeside = 1e-5;
  const Vec3 place_mm =
      0.5 * (MeetingPoint(chief, ray((down + kBeside * sagittal).normalized())) +
             MeetingPoint(chief, ray((down + kBeside * tangential).normalized())));
  return turn.transpose() * (place_mm - head.origin_mm);
}

std::vector<CubeMark> MarksOf(const TrueHead& head, int nodes = 5, double noise_mm = 0) {
  const auto cube =
      MakeCubePattern({{Vec3(-28, -27, -33), Vec3(28, 27, -3)}, nodes, 2}).value();
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1);
  std::vector<CubeMark> marks;
  for (const Vec3& at : cube.marks_mm) {
    CubeMark mark{at.head<2>(), at.z() + head.block_mm, Vec3::Zero()};
    mark.measured_mm = Traced(head, mark.field_mm, mark.z_mm) +
                       noise_mm * Vec3(noise(random), noise(random), noise(random));
    marks.push_back(mark);
  }
  return marks;
}

/// What a profile of the data sheets has.
HeadState Profile() {
  HeadState known{};
  known[kOriginX] = known[kOriginY] = -30;
  known[kTop] = 60;
  known[kXScale] = known[kYScale] = known[kZRatio] = 1;
  known[kPupilX] = known[kPupilY] = 1 / 140.0;
  known[kIndex] = 1.519473;
  return known;
}

double Value(const CubeFit& fit, HeadUnknown unknown) {
  return fit.figures[unknown].figure.value;
}

void ExpectTrue(const CubeFit& fit, const TrueHead& head, double times) {
  const auto expect = [&](HeadUnknown unknown, double truth, double tolerance) {
    EXPECT_NEAR(Value(fit, unknown), truth, times * tolerance) << "unknown " << unknown;
  };
  expect(kXScale, head.x_ratio, 2e-5);
  expect(kYScale, head.y_ratio, 2e-5);
  expect(kRotation, head.x_turn, 2e-5);
  expect(kSquareness, head.x_turn - head.y_turn, 3e-5);
  expect(kZRatio, head.z_ratio, 5e-5);
  expect(kTiltX, head.rise_x, 2e-5);
  expect(kTiltY, head.rise_y, 2e-5);
  expect(kLeanX, head.lean.x(), 4e-5);
  expect(kLeanY, head.lean.y(), 4e-5);
  expect(kPupilX, 1 / head.pupil_mm.x(), 1e-5);
  expect(kPupilY, 1 / head.pupil_mm.y(), 1e-5);
  expect(kIndex, head.index, 1e-4);
}

// Without noise what is left is the second order of tilt and lean.
TEST(CubeFit, FindsEveryErrorWithoutNoise) {
  const TrueHead head;
  const auto fit = FitCube(MarksOf(head), Profile(), {head.block_mm});
  ASSERT_TRUE(fit) << fit.error().message;
  ExpectTrue(*fit, head, 1);
  EXPECT_LT(fit->deviation_mm, 5e-4);
  EXPECT_EQ(fit->figures[kIndex].state, FigureState::kKnown);
  EXPECT_EQ(fit->figures[kZRatio].state, FigureState::kFound);
  EXPECT_EQ(fit->coordinate_count, 150);
}

// 20 um of a good caliper; a mark that was read 1 mm wrong is named and changes nothing.
TEST(CubeFit, NamesAMarkThatWasReadWrong) {
  const TrueHead head;
  auto marks = MarksOf(head, 5, 0.02);
  const auto right = FitCube(marks, Profile(), {head.block_mm});
  ASSERT_TRUE(right);
  EXPECT_THAT(right->strays, ElementsAre());
  EXPECT_NEAR(right->deviation_mm, 0.02, 0.005);
  ExpectTrue(*right, head, 40);
  for (const HeadUnknown unknown : {kXScale, kYScale, kZRatio, kTiltX, kTiltY}) {
    const Figure& figure = right->figures[unknown].figure;
    EXPECT_LT(figure.interval95, 1e-3) << unknown;
  }
  marks[7].measured_mm.x() += 1;
  marks[31].measured_mm.z() -= 1;
  const auto fit = FitCube(marks, Profile(), {head.block_mm});
  ASSERT_TRUE(fit);
  EXPECT_THAT(fit->strays, ElementsAre(7, 31));
  EXPECT_NEAR(fit->residuals_mm[7].x(), 1, 0.1);
  ExpectTrue(*fit, head, 40);
}

// The same measurements say that the glass has another index, or that z goes another way.
TEST(CubeFit, SharesTheDepthBetweenGlassAndAxisByWhatIsKnown) {
  TrueHead head;
  head.z_ratio = 1;
  head.index = 1.535;
  const auto by_axis = FitCube(MarksOf(head), Profile(), {60}, KnownOfHead::kZ);
  ASSERT_TRUE(by_axis);
  EXPECT_EQ(by_axis->figures[kZRatio].state, FigureState::kKnown);
  ExpectTrue(*by_axis, head, 1);
  const auto by_index = FitCube(MarksOf(head), Profile(), {60});
  ASSERT_TRUE(by_index);
  EXPECT_NEAR(Value(*by_index, kZRatio), 1.535 / 1.519473, 1e-3);

  // With the distances of the pupil known, the angles separate both.
  TrueHead both;
  both.pupil_mm = {140, 140};
  both.z_ratio = 1.02;
  both.index = 1.535;
  const auto by_pupil = FitCube(MarksOf(both), Profile(), {60}, KnownOfHead::kPupil);
  ASSERT_TRUE(by_pupil);
  ExpectTrue(*by_pupil, both, 5);
}

TEST(CubeFit, AHeadThatIsRightKeepsItsProfile) {
  TrueHead head;
  head.x_ratio = head.y_ratio = head.z_ratio = 1;
  head.x_turn = head.y_turn = head.rise_x = head.rise_y = 0;
  head.lean = Vec2::Zero();
  head.pupil_mm = {140, 140};
  head.origin_mm = {-30, -30, 0};
  const auto fit = FitCube(MarksOf(head, 6, 0.02), Profile(), {60});
  ASSERT_TRUE(fit);
  int found = 0;
  for (int unknown = kXScale; unknown < kHeadUnknowns; ++unknown) {
    found += fit->figures[static_cast<std::size_t>(unknown)].state == FigureState::kFound;
  }
  EXPECT_LE(found, 1) << "one of twenty figures is beyond its interval by chance";
}

// A telecentric lens, which the profile knows as one.
TEST(CubeFit, ATelecentricLensStaysOne) {
  TrueHead head;
  head.pupil_mm = {1e9, 1e9};
  HeadState known = Profile();
  known[kPupilX] = known[kPupilY] = 0;
  for (const double noise_mm : {0.0, 0.02}) {
    const auto fit = FitCube(MarksOf(head, 5, noise_mm), known, {60});
    ASSERT_TRUE(fit) << noise_mm;
    EXPECT_LT(std::abs(Value(*fit, kPupilX)), 1 / 1500.0);
    EXPECT_LT(std::abs(Value(*fit, kPupilY)), 1 / 1500.0);
    EXPECT_NEAR(Value(*fit, kXScale), head.x_ratio, noise_mm > 0 ? 5e-4 : 2e-5);
    EXPECT_NEAR(Value(*fit, kZRatio), head.z_ratio, noise_mm > 0 ? 2e-3 : 1e-4);
  }
  const auto vague = FitCube(MarksOf(head), known, {60}, KnownOfHead::kPupil);
  ASSERT_TRUE(vague);
  EXPECT_EQ(vague->figures[kIndex].state, FigureState::kUndetermined);
}

// A caliper along x and y alone says nothing of depth, and says so.
TEST(CubeFit, WhatWasNotMeasuredIsNotDetermined) {
  TrueHead head;
  head.pupil_mm = {140, 140};
  head.z_ratio = 1;
  auto marks = MarksOf(head, 5, 0.02);
  for (CubeMark& mark : marks) mark.measured_mm.z() = kNan;
  const auto fit = FitCube(marks, Profile(), {60});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_EQ(fit->figures[kZRatio].state, FigureState::kUndetermined);
  EXPECT_EQ(fit->figures[kXScale].state, FigureState::kFound);
  EXPECT_NEAR(Value(*fit, kXScale), head.x_ratio, 2e-3);
  marks.resize(3);
  const auto few = FitCube(marks, Profile(), {60});
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().code, ErrorCode::kMissing);
}

TEST(CubePattern, NoMarkCoversAnotherFromAbove) {
  const auto cube = MakeCubePattern({{Vec3(5, 5, 4), Vec3(55, 45, 52)}, 5, 3}).value();
  ASSERT_EQ(cube.marks_mm.size(), 75u);
  EXPECT_EQ(cube.signs_mm.size(), 2u);
  Box3 box;
  PointList all = cube.marks_mm;
  all.insert(all.end(), cube.signs_mm.begin(), cube.signs_mm.end());
  for (std::size_t i = 0; i < all.size(); ++i) {
    box.Extend(all[i]);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((all[i] - all[j]).head<2>().norm(), 1) << i << " " << j;
    }
  }
  EXPECT_EQ(box.min_mm, Vec3(5, 5, 4));
  EXPECT_TRUE(box.max_mm.isApprox(Vec3(55, 45, 52)));
  EXPECT_FALSE(MakeCubePattern({{Vec3(0, 0, 0), Vec3(8, 8, 8)}, 5, 2}));
  EXPECT_FALSE(MakeCubePattern({{Vec3(0, 0, 0), Vec3(50, 50, 50)}, 2, 2}));
  EXPECT_FALSE(MakeCubePattern({{Vec3(0, 0, 0), Vec3(50, 50, 50)}, 5, 1}));
}

}  // namespace
}  // namespace intaglio::calibrate
