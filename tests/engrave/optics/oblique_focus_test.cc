#include "engrave/optics/oblique_focus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>

namespace intaglio::optics {
namespace {

/// N-BK7 by Schott's coefficients.
double IndexAt(double wavelength_um) {
  const double b[] = {1.03961212, 0.231792344, 1.01046945};
  const double c[] = {0.00600069867, 0.0200179144, 103.560653};
  const double squared = wavelength_um * wavelength_um;
  double sum = 1;
  for (int i = 0; i < 3; ++i) sum += b[i] * squared / (squared - c[i]);
  return std::sqrt(sum);
}

const double kGreen = IndexAt(0.532), kUltraviolet = IndexAt(0.355),
             kInfrared = IndexAt(1.064);
const ScanLens kShort{Vec2::Constant(140)}, kLong{Vec2::Constant(224)}, kStraight{};

struct Row {
  ScanLens lens;
  Vec2 field_mm;
  double depth_mm;  // n h
  double n;
  double x_mm, sagittal_mm, tangential_mm, middle_mm;
};

// Computed by another program, which printed six decimals.
std::vector<Row> Table() {
  const auto d = [](const ScanLens& lens, double u, double v, double n, double depth,
                    std::array<double, 4> found) {
    return Row{lens, Vec2(u, v), depth, n, found[0], found[1], found[2], found[3]};
  };
  return {
      d(kShort, 17.5, 0, kGreen, 5, {17.501822, 5.022095, 5.066577, 5.044336}),
      d(kShort, 17.5, 0, kGreen, 100, {17.536433, 100.441894, 101.331549, 100.886721}),
      d(kShort, 35, 0, kGreen, 5, {35.014573, 5.087803, 5.268062, 5.177933}),
      d(kShort, 35, 0, kGreen, 30, {35.087439, 30.526819, 31.608372, 31.067596}),
      d(kShort, 35, 0, kGreen, 60, {35.174878, 61.053637, 63.216745, 62.135191}),
      d(kShort, 35, 35, kGreen, 30, {35.174878, 31.044699, 33.244503, 32.144601}),
      d(kShort, 35, 35, kGreen, 60, {35.349756, 62.089398, 66.489006, 64.289202}),
      d(kShort, 35, 35, kGreen, 100, {35.582926, 103.482329, 110.815009, 107.148669}),
      d(kLong, 27.5, 0, kGreen, 30, {27.510355, 30.127886, 30.385295, 30.256591}),
      d(kLong, 55, 0, kGreen, 60, {55.165676, 61.016654, 63.101934, 62.059294}),
      d(kLong, 55, 55, kGreen, 5, {55.027613, 5.168054, 5.521296, 5.344675}),
      d(kLong, 55, 55, kGreen, 100, {55.552252, 103.361074, 110.425923, 106.893498}),
      d(kStraight, 30, 12, kGreen, 60, {30, 60, 60, 60}),
      d(kShort, 35, 0, kUltraviolet, 60, {35.175941, 61.072904, 63.276611, 62.174757}),
      d(kShort, 35, 35, kUltraviolet, 60, {35.351882, 62.127282, 66.610786, 64.369034}),
      d(kLong, 55, 55, kUltraviolet, 60, {55.333365, 62.053231, 66.372885, 64.213058})};
}

TEST(ObliqueFocus, GivesThePublishedDigits) {
  for (const Row& row : Table()) {
    const HeadPosition head{row.field_mm, row.depth_mm / row.n};
    const LineFoci foci = FociOf(head, row.lens, row.n);
    const Vec3 middle_mm = MiddleFocusOf(head, row.lens, row.n);
    EXPECT_NEAR(middle_mm.x(), row.x_mm, 1e-6) << row.field_mm.transpose();
    EXPECT_NEAR(foci.sagittal_mm, row.sagittal_mm, 1e-6);
    EXPECT_NEAR(foci.tangential_mm, row.tangential_mm, 1e-6);
    EXPECT_NEAR(foci.middle_mm(), row.middle_mm, 1e-6);
    EXPECT_NEAR(middle_mm.z(), row.middle_mm, 1e-6);
    const LineFoci again =
        FociAtDepth(middle_mm.z(), row.lens.TangentAt(row.field_mm), row.n);
    EXPECT_NEAR(again.sagittal_mm, foci.sagittal_mm, 1e-11);
    EXPECT_NEAR(again.apart_mm(), foci.apart_mm(), 1e-11);
  }
}

TEST(ObliqueFocus, InverseGivesThePublishedDigitsInFewSteps) {
  struct {
    ScanLens lens;
    Vec3 place_mm, head;
  } const rows[] = {{kShort, {20, 20, 60}, {19.936813, 19.936813, 38.597414}},
                    {kShort, {25, 25, 55}, {24.888718, 24.888718, 34.939237}},
                    {kShort, {30, -12, 100}, {29.797428, -11.918971, 63.901698}},
                    {kShort, {31.5, 31.5, 100}, {31.112396, 31.112396, 62.299609}},
                    {kLong, {20, 20, 60}, {19.984247, 19.984247, 39.133846}},
                    {kLong, {49.5, 49.5, 100}, {49.126926, 49.126926, 62.386972}},
                    {kStraight, {20, -7, 60}, {20, -7, 60 / kGreen}}};
  for (const auto& row : rows) {
    const auto solved = PositionFor(row.place_mm, row.lens, kGreen, 1e-9);
    ASSERT_TRUE(solved);
    EXPECT_LT((solved->head.AsVector() - row.head).norm(), 2e-6);
    EXPECT_LE(solved->steps, 4);
    const auto coarse = PositionFor(row.place_mm, row.lens, kGreen, 1e-6);
    EXPECT_LE(coarse->steps, 3);
  }
}

/// By Snell's law in vectors: a ray that passes (u, v) at the height h below the face in
/// air, with these slopes, at its depth z in the glass.
struct Ray {
  Vec3 at_face_mm, way;

  Vec2 At(double z_mm) const {
    return at_face_mm.head<2>() + way.head<2>() / way.z() * z_mm;
  }
};

Ray Traced(const HeadPosition& head, const Vec2& slopes, double n) {
  const Vec3 air = Vec3(slopes.x(), slopes.y(), 1).normalized();
  const Vec3 face(0, 0, -1);
  const double cosine = -face.dot(air), ratio = 1 / n;
  const Vec3 glass =
      ratio * air +
      (ratio * cosine - std::sqrt(1 - ratio * ratio * (1 - cosine * cosine))) * face;
  const Vec2 at_mm = head.field_mm - slopes * head.below_face_mm;
  return {Vec3(at_mm.x(), at_mm.y(), 0), glass};
}

/// Where two rays come nearest to each other, seen along `across`.
double Crossing(const Ray& a, const Ray& b, const Vec2& across) {
  const double apart = across.dot(a.At(0) - b.At(0));
  const double closing = across.dot((b.At(1) - b.At(0)) - (a.At(1) - a.At(0)));
  return apart / closing;
}

// Rays of a pencil that is 1e-4 wide: its own aberration is below a nm.
TEST(ObliqueFocus, LiesWhereTracedRaysMeet) {
  constexpr double kThin = 1e-4;
  double worst_place_um = 0, worst_depth_um = 0;
  for (const double n : {kUltraviolet, kGreen, kInfrared}) {
    for (const Vec2& pupil_mm : {Vec2(140, 140), Vec2(150, 128), Vec2(224, 224)}) {
      const ScanLens lens{pupil_mm};
      for (double x = -30; x <= 30; x += 7.5) {
        for (double y = -30; y <= 30; y += 7.5) {
          for (const double z : {5.0, 30.0, 55.0, 100.0}) {
            const Vec3 place_mm(x, y, z);
            const auto solved = PositionFor(place_mm, lens, n);
            ASSERT_TRUE(solved);
            const Vec2 slopes = lens.SlopesAt(solved->head.field_mm);
            const Vec2 radial =
                slopes.norm() > 0 ? Vec2(slopes.normalized()) : Vec2(1, 0);
            const Vec2 around(-radial.y(), radial.x());
            const auto ray = [&](const Vec2& by) {
              return Traced(solved->head, slopes + kThin * by, n);
            };
            const double tangential_mm = Crossing(ray(radial), ray(-radial), radial);
            const double sagittal_mm = Crossing(ray(around), ray(-around), around);
            const double middle_mm = 0.5 * (tangential_mm + sagittal_mm);
            worst_depth_um = std::max(worst_depth_um, 1000 * std::abs(middle_mm - z));
            worst_place_um = std::max(
                worst_place_um,
                1000 * (ray(Vec2::Zero()).At(middle_mm) - place_mm.head<2>()).norm());
          }
        }
      }
    }
  }
  EXPECT_LT(worst_place_um, 0.01);
  EXPECT_LT(worst_depth_um, 0.1);
}

// What a program is wrong by that leaves the refraction out: by the depth alone, 165 um
// beside and 2 mm too deep over a cube of 50 mm that begins 5 mm below the face.
TEST(ObliqueFocus, ScalingTheDepthAloneMissesByMillimetres) {
  const HeadPosition head{Vec2(25, 25), 55 / kGreen};
  const Vec3 focus_mm = MiddleFocusOf(head, kShort, kGreen);
  EXPECT_NEAR(1000 * (focus_mm.head<2>() - head.field_mm).norm(), 165, 1);
  EXPECT_NEAR(1000 * (focus_mm.z() - 55), 1997, 2);
}

TEST(ObliqueFocus, SlopesAreTheDerivative) {
  const ScanLens lens{Vec2(150, 128)};
  const HeadPosition head{Vec2(25, -30), 35};
  const Mat3 slopes = MiddleFocusSlopes(head, lens, kGreen);
  constexpr double kStep = 1e-4;
  for (int axis = 0; axis < 3; ++axis) {
    const auto moved = [&](double by) {
      const Vec3 to = head.AsVector() + by * Vec3::Unit(axis);
      return MiddleFocusOf({to.head<2>(), to.z()}, lens, kGreen);
    };
    const Vec3 slope = (moved(kStep) - moved(-kStep)) / (2 * kStep);
    EXPECT_LT((slope - slopes.col(axis)).norm(), 1e-9);
  }
}

TEST(ObliqueFocus, RefusesRaysSteeperThan45Degrees) {
  EXPECT_FALSE(PositionFor(Vec3(150, 0, 10), kShort, kGreen));
  EXPECT_FALSE(PositionFor(Vec3(std::nan(""), 0, 10), kShort, kGreen));
}

}  // namespace
}  // namespace intaglio::optics
