// What engrave/machine/kinematics.h guarantees, for every kind in the registry. A new
// kind needs a row in Samples(): EveryKindIsSampled fails without it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "engrave/machine/kinematics.h"
#include "engrave/machine/scan_head.h"

namespace intaglio::machine {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::HasSubstr;

struct Sample {
  const char* name;
  KinematicsOptions options;
  Box3 reached_mm;               // all of its places can be reached
  PointList out_of_reach_mm;     // and none of these
  const char* remedy = "place";  // part of the sentence for those
};

/// A spline of what makes the head's slopes grow to the corners still more.
std::shared_ptr<const galvo::CorrectionTable> AgainstPincushion() {
  galvo::FieldGrid grid = galvo::CentredGrid(120, 41);
  for (int j = 0; j < grid.nodes; ++j) {
    for (int i = 0; i < grid.nodes; ++i) {
      const Vec2 at_mm = grid.PlaceOf(i, j);
      grid.values_mm[grid.IndexOf(i, j)] = -4e-6 * at_mm.squaredNorm() * at_mm;
    }
  }
  return std::make_shared<galvo::CorrectionTable>(
      galvo::CorrectionTable::Make(std::move(grid), galvo::Interpolation::kSpline)
          .value());
}

std::vector<Sample> HeadSamples() {
  const Box3 field{Vec3(-30, -28, -40), Vec3(29, 30, -1)};
  const PointList beyond = {Vec3(170, 0, -20), Vec3(0, -150, 3)};
  ScanHeadOptions head;
  std::vector<Sample> samples = {
      {"head_straight", head, field, {Vec3(std::nan(""), 0, 0)}, "place"}};
  head.lens.pupil_mm = {150, 128};
  head.refractive_index = 1.519473;
  samples.push_back({"head_over_glass", head, field, beyond, "block_origin_mm"});
  samples.push_back({"head_in_air",
                     head,
                     {Vec3(-30, -28, 1), Vec3(29, 30, 20)},
                     beyond,
                     "block_origin_mm"});
  head.z = {true, false, 0.98};
  head.corrections = AgainstPincushion();
  samples.push_back({"head_corrected", head, field, beyond, "block_origin_mm"});
  head.place_per_field = FieldMatrix(1.04, 0.95, 0.02, -0.03);
  samples.push_back({"head_skewed", head, field, beyond, "block_origin_mm"});
  return samples;
}

std::vector<Sample> Samples() {
  const PointList no_numbers = {Vec3(std::nan(""), 0, 0),
                                Vec3(0, std::numeric_limits<double>::infinity(), 0)};
  const Box3 work{Vec3(-20, -10, -5), Vec3(170, 150, 100)};
  std::vector<Sample> samples = {
      {"head", CartesianOptions{}, work, no_numbers},
      {"table", CartesianOptions{{true}, {true}, {true}}, work, no_numbers},
      {"table_and_lens", CartesianOptions{{true}, {true, true}, {false}}, work,
       no_numbers},
      {"corrected",
       CartesianOptions{
           {true, false, 1.0004}, {false, true, 0.91}, {false, false, 1.1}, -0.09},
       work, no_numbers}};
  PolarOptions polar;
  const PointList around = {Vec3(0, 0, 0), Vec3(10, 40, 3), Vec3(0, 349.8, 0),
                            Vec3(300, 300, 0)};
  const Box3 piece{Vec3(-25, 85, 0), Vec3(25, 135, 30)};
  samples.push_back({"polar_left", polar, piece, around, "block_origin_mm"});
  polar.side = ArmSide::kRight;
  polar.z = {true, false, 0.98};
  samples.push_back({"polar_right", polar, piece, around, "block_origin_mm"});
  polar.frame_turn_rad = -2.5;
  samples.push_back({"polar_station", polar, piece, around, "block_origin_mm"});
  polar.arm_length_mm = 230;
  samples.push_back({"long_arm", polar, piece, {Vec3(1, 20, 0)}, "block_origin_mm"});
  for (Sample& sample : HeadSamples()) samples.push_back(std::move(sample));
  return samples;
}

class Conformance : public testing::TestWithParam<Sample> {
 protected:
  Vec3 Place() {
    const Box3& box = GetParam().reached_mm;
    Vec3 share;
    for (double& s : share) s = std::uniform_real_distribution(0.0, 1.0)(random_);
    return box.min_mm + share.cwiseProduct(box.size_mm());
  }
  Vec3 AxesAt(const Vec3& place_mm, const Vec3& near = Vec3::Zero()) const {
    const auto axes = kinematics_->ToAxes(place_mm, near);
    EXPECT_TRUE(axes) << (axes ? "" : axes.error().message);
    return axes.value_or(Vec3::Zero());
  }
  bool Rotary(int axis) const {
    return kinematics_->axes()[static_cast<std::size_t>(axis)].unit == AxisUnit::kRad;
  }

  std::shared_ptr<const Kinematics> kinematics_ = MakeKinematics(GetParam().options);
  std::mt19937 random_{7};
};

TEST_P(Conformance, K1ComesBackToThePlace) {
  for (int i = 0; i < 2000; ++i) {
    const Vec3 place_mm = Place();
    EXPECT_LT((kinematics_->ToPlace(AxesAt(place_mm)) - place_mm).norm(), 1e-9);
    // Turned on and on, too: a turn of 2 pi is not exact.
    const Vec3 turned = AxesAt(place_mm, Vec3::Constant(200));
    EXPECT_LT((kinematics_->ToPlace(turned) - place_mm).norm(), 1e-9);
  }
}

TEST_P(Conformance, K2TakesTheNearestTurn) {
  for (int i = 0; i < 2000; ++i) {
    const Vec3 place_mm = Place();
    const Vec3 near = 2 * Place();
    const Vec3 axes = AxesAt(place_mm, near), first = AxesAt(place_mm);
    for (int axis = 0; axis < 3; ++axis) {
      if (!Rotary(axis)) {
        EXPECT_EQ(axes[axis], first[axis]);
        continue;
      }
      EXPECT_LE(std::abs(axes[axis] - near[axis]), pi + 1e-9);
      const double turns = (axes[axis] - first[axis]) / (2 * pi);
      EXPECT_NEAR(turns, std::round(turns), 1e-9) << "another configuration";
    }
  }
}

// The step of the axes is bounded by that of the place, over the smallest stretch of the
// derivative; a jump would be half a turn or more.
TEST_P(Conformance, K2IsContinuousAlongAPath) {
  constexpr int kSteps = 4000;
  for (int path = 0; path < 20; ++path) {
    const Vec3 from_mm = Place(), to_mm = Place();
    const double step_mm = (to_mm - from_mm).norm() / kSteps;
    Vec3 before = AxesAt(from_mm, Vec3::Constant(50));
    for (int i = 1; i <= kSteps; ++i) {
      const Vec3 axes = AxesAt(from_mm + (to_mm - from_mm) * i / kSteps, before);
      const double stretch_mm =
          kinematics_->ScaleAt(before).jacobiSvd().singularValues().minCoeff();
      ASSERT_LE((axes - before).norm(), 1.1 * step_mm / stretch_mm + 1e-9);
      before = axes;
    }
  }
}

TEST_P(Conformance, K3ScaleIsTheDerivative) {
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 500; ++i) {
    const Vec3 axes = AxesAt(Place());
    const Mat3 scale = kinematics_->ScaleAt(axes);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = kStep * Vec3::Unit(axis);
      const Vec3 slope =
          (kinematics_->ToPlace(axes + step) - kinematics_->ToPlace(axes - step)) /
          (2 * kStep);
      // The third derivative is at most 350 mm, times the square of the step over 6;
      // rounding leaves 1e-13 mm over the step.
      EXPECT_LT((scale.col(axis) - slope).norm(), 1e-7);
    }
    EXPECT_GT(std::abs(scale.determinant()), 1e-3);
  }
}

TEST_P(Conformance, K3BoundsHoldAndAreNotIdle) {
  const ScaleBounds bounds = kinematics_->BoundsOver(GetParam().reached_mm);
  Vec3 widest_mm = Vec3::Zero();
  double any_mm = 0;
  const Box3& box = GetParam().reached_mm;
  for (int i = 0; i < 5000; ++i) {
    Vec3 place_mm = Place();
    if (i < 8) {
      for (int axis = 0; axis < 3; ++axis) {
        place_mm[axis] = (i >> axis & 1) != 0 ? box.max_mm[axis] : box.min_mm[axis];
      }
    }
    const Mat3 scale = kinematics_->ScaleAt(AxesAt(place_mm));
    for (int axis = 0; axis < 3; ++axis) {
      widest_mm[axis] = std::max(widest_mm[axis], scale.col(axis).norm());
    }
    any_mm = std::max(any_mm, scale.jacobiSvd().singularValues().maxCoeff());
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(widest_mm[axis], bounds.axis_mm[axis] + 1e-9);
    EXPECT_GE(widest_mm[axis], bounds.axis_mm[axis] - 1e-9) << "a corner reaches it";
  }
  EXPECT_LE(any_mm, bounds.any_mm + 1e-9);
  EXPECT_GE(any_mm, 0.6 * bounds.any_mm) << "at most 1 / sqrt(2) lost by the estimate";
}

TEST_P(Conformance, K4RefusesWithPlaceAndRemedy) {
  for (const Vec3& place_mm : GetParam().out_of_reach_mm) {
    const auto axes = kinematics_->ToAxes(place_mm, Vec3::Zero());
    ASSERT_FALSE(axes) << place_mm.transpose();
    EXPECT_EQ(axes.error().code, ErrorCode::kOutsideBlock);
    EXPECT_THAT(axes.error().message,
                AllOf(HasSubstr("the focus at ("), HasSubstr(GetParam().remedy)));
    EXPECT_FALSE(axes.error().value.empty());
  }
}

TEST_P(Conformance, K5GivesTheSameBits) {
  const auto again = MakeKinematics(GetParam().options);
  for (int i = 0; i < 500; ++i) {
    const Vec3 place_mm = Place();
    const Vec3 axes = AxesAt(place_mm, Vec3::Constant(9));
    (void)kinematics_->ToAxes(Place(), axes);  // nothing is remembered
    EXPECT_EQ(axes, AxesAt(place_mm, Vec3::Constant(9)));
    EXPECT_EQ(axes, again->ToAxes(place_mm, Vec3::Constant(9)).value());
    EXPECT_EQ(kinematics_->ToPlace(axes), again->ToPlace(axes));
  }
}

INSTANTIATE_TEST_SUITE_P(Kinematics, Conformance, testing::ValuesIn(Samples()),
                         [](const auto& sample) { return sample.param.name; });

TEST(Registry, EveryKindIsSampledAndHasANameOfItsOwn) {
  std::set<std::size_t> sampled;
  for (const Sample& sample : Samples()) sampled.insert(sample.options.index());
  EXPECT_EQ(sampled.size(), KinematicsKinds().size());
  std::set<std::string_view> names;
  for (const KinematicsKind& kind : KinematicsKinds()) names.insert(kind.name);
  EXPECT_EQ(names.size(), KinematicsKinds().size());
}

TEST(BranchStart, IsTheMiddleOfATravelThatHasEnds) {
  const double endless = std::numeric_limits<double>::infinity();
  EXPECT_EQ(BranchStart({Vec3(2, -endless, -1), Vec3(6, endless, 3)}), Vec3(4, 0, 1));
}

}  // namespace
}  // namespace intaglio::machine
