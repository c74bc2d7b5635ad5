#include "engrave/motion/axis/lq.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace intaglio::motion {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// Controls and states of a course by the recursion.
struct Course {
  VectorXd controls;
  std::vector<Vector2d> states;  // of the stages' starts, and the end
};

Course Follow(const LqRecursion& recursion, Vector2d state) {
  Course run{VectorXd(recursion.count()), {state}};
  for (std::size_t j = 0; j < recursion.count(); ++j) {
    run.controls[static_cast<Eigen::Index>(j)] = recursion.ControlAt(j, state);
    state = recursion.Next(state, run.controls[static_cast<Eigen::Index>(j)]);
    run.states.push_back(state);
  }
  return run;
}

/// The cost of any controls, by going through the stages; `end` their weight of the end.
double Cost(const LqStage& stage, Vector2d state, const VectorXd& controls,
            const Matrix2d& end) {
  double cost = 0.0;
  for (const double u : controls) {
    cost += 0.5 * (state.dot(stage.weight * state) + stage.control_weight * u * u);
    state = stage.transition * state + stage.control * u;
  }
  return cost + 0.5 * state.dot(end * state);
}

/// K[0], for which the cost of the course from X is S = X^T K X / 2: from the costs of
/// three courses.
Matrix2d ValueOf(const LqRecursion& recursion, const LqStage& stage,
                 const Matrix2d& end) {
  const auto square = [&](const Vector2d& start) {
    return 2.0 * Cost(stage, start, Follow(recursion, start).controls, end);
  };
  const double k11 = square({1.0, 0.0});
  const double k22 = square({0.0, 1.0});
  const double k12 = 0.5 * (square({1.0, 1.0}) - k11 - k22);
  return Matrix2d{{k11, k12}, {k12, k22}};
}

/// The end that controls lead to from 0: what a disturbance must not move.
Vector2d EndOf(const LqStage& stage, const VectorXd& controls) {
  Vector2d state = Vector2d::Zero();
  for (const double u : controls) state = stage.transition * state + stage.control * u;
  return state;
}

TEST(Lq, TheScalarCaseIsFibonacci) {
  // A = B = Q = R = K[N] = 1: K = 1 + K / (K + 1), 1, 3/2, 8/5, 21/13 ...
  // The second state is by itself.
  LqStage stage;
  stage.transition = Matrix2d::Identity();
  stage.control << 1.0, 0.0;
  stage.weight = Matrix2d::Identity();
  const std::size_t count = 40;
  const LqRecursion recursion(stage, count, Matrix2d::Identity());
  double upper = 1.0;
  double lower = 1.0;
  for (std::size_t j = count; j-- > 0;) {
    // u[j] = -K[j+1] / (K[j+1] + 1) x.
    EXPECT_NEAR(recursion.ControlAt(j, {1.0, 0.0}), -upper / (upper + lower), 1e-14);
    const double next = upper + lower;
    upper = next + upper;
    lower = next;
  }
  // The stationary one is the golden ratio.
  const double golden = (1.0 + std::sqrt(5.0)) / 2;
  EXPECT_NEAR(ValueOf(recursion, stage, Matrix2d::Identity())(0, 0), golden, 1e-14);
  EXPECT_NEAR(recursion.ControlAt(0, {1.0, 0.0}), -golden / (golden + 1), 1e-14);
}

TEST(Lq, TheStationaryCaseSolvesTheAlgebraicEquation) {
  const LqStage stage = AxisStage({-3.0, 2.0}, {40.0, 0.7, 0.05}, 0.01);
  const LqRecursion recursion(stage, 3000, Matrix2d::Identity());
  const Matrix2d k = ValueOf(recursion, stage, Matrix2d::Identity());
  // In the form without inverses of K, as textbooks have it.
  const Matrix2d& a = stage.transition;
  const Vector2d& b = stage.control;
  const Vector2d kb = k * b;
  const Matrix2d residual =
      stage.weight + a.transpose() * k * a -
      a.transpose() * kb * kb.transpose() * a / (stage.control_weight + b.dot(kb)) - k;
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-12 * k.cwiseAbs().maxCoeff());
  // A cost is flat about its minimum; the controls themselves are those of K.
  for (const Vector2d& x : {Vector2d(1.0, 0.0), Vector2d(0.0, 1.0)}) {
    const double wanted = -kb.dot(a * x) / (stage.control_weight + b.dot(kb));
    EXPECT_NEAR(recursion.ControlAt(0, x), wanted, 1e-11 * std::abs(wanted));
  }
}

TEST(Lq, ShortStagesTendToTheContinuousStationaryCase) {
  // x'' = u: K12 = sqrt(q r), K22 = sqrt(r (s + 2 K12)), K11 = K12 K22 / r.
  const double q = 9.0;
  const double s = 2.0;
  const double r = 0.25;
  const double k12 = std::sqrt(q * r);
  const double k22 = std::sqrt(r * (s + 2 * k12));
  Matrix2d wanted;
  wanted << k12 * k22 / r, k12, k12, k22;
  double before = 0.0;
  for (const double stage_s : {0.02, 0.01, 0.005}) {
    const LqStage stage = AxisStage({}, {q, s, r}, stage_s);
    const LqRecursion recursion(stage, static_cast<std::size_t>(20 / stage_s),
                                Matrix2d::Identity());
    const Matrix2d value = ValueOf(recursion, stage, Matrix2d::Identity());
    const double off = (value - wanted).cwiseAbs().maxCoeff();
    EXPECT_LT(off, 10 * stage_s);
    // The error is of first order.
    if (before > 0) {
      EXPECT_NEAR(off, before / 2, 0.05 * before);
    }
    before = off;
  }
}

TEST(Lq, MinimumEnergyIsTheClosedFormOfTheDoubleIntegrator) {
  // Q = 0, fixed end: K(0) = [12/T^3, 6/T^2; 6/T^2, 4/T] for short stages.
  const double t = 2.0;
  const std::size_t count = 400;
  const LqStage stage = AxisStage({}, {}, t / count);
  const LqRecursion recursion(stage, count, Matrix2d::Zero());
  Matrix2d wanted;
  wanted << 12 / (t * t * t), 6 / (t * t), 6 / (t * t), 4 / t;
  const Matrix2d value = ValueOf(recursion, stage, Matrix2d::Zero());
  EXPECT_LT((value - wanted).cwiseAbs().maxCoeff(), 2e-5);
}

TEST(Lq, MinimumEnergyFromRestToRestIsLinearInTime) {
  // Held controls are exactly u[j] = 6 (N - 1 - 2 j) / (N (N^2 - 1)) in units of stages.
  for (const std::size_t count : {2u, 3u, 8u, 100u}) {
    const LqRecursion recursion(AxisStage({}, {}, 1.0), count, Matrix2d::Zero());
    const Course run = Follow(recursion, {-1.0, 0.0});
    const double n = static_cast<double>(count);
    for (std::size_t j = 0; j < count; ++j) {
      const double wanted =
          6 * (n - 1 - 2.0 * static_cast<double>(j)) / (n * (n * n - 1));
      EXPECT_NEAR(run.controls[static_cast<Eigen::Index>(j)], wanted, 1e-13);
    }
    EXPECT_LT(run.states.back().norm(), 1e-13);
  }
}

TEST(Lq, NoOtherControlsToTheSameEndAreCheaper) {
  const LqStage stage = AxisStage({-4.0, 1.5}, {30.0, 5.0, 1.0}, 0.05);
  const Eigen::Index count = 40;
  const LqRecursion recursion(stage, count, Matrix2d::Zero());
  const Vector2d start(-1.0, 0.3);
  const Course best = Follow(recursion, start);
  EXPECT_LT(best.states.back().norm(), 1e-12);
  const double smallest = Cost(stage, start, best.controls, Matrix2d::Zero());

  // The ends of the unit controls, to take the part away that would move the end.
  Eigen::Matrix<double, 2, Eigen::Dynamic> reach(2, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    reach.col(j) = EndOf(stage, VectorXd::Unit(count, j));
  }
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 200; ++round) {
    VectorXd change = VectorXd::NullaryExpr(count, [&] { return normal(random); });
    change -= reach.transpose() * (reach * reach.transpose()).inverse() * reach * change;
    ASSERT_LT(EndOf(stage, change).norm(), 1e-12);
    const double up = Cost(stage, start, best.controls + change, Matrix2d::Zero());
    const double down = Cost(stage, start, best.controls - change, Matrix2d::Zero());
    EXPECT_GT(up, smallest);
    // Stationary: both sides cost the same more.
    EXPECT_NEAR(up - smallest, down - smallest, 1e-9 * up);
  }
}

TEST(Lq, AWeightedEndIsNotReachedButCheapest) {
  const LqStage stage = AxisStage({-1.0, 1.0}, {2.0, 0.0, 1.0}, 0.1);
  const Matrix2d end = Vector2d(50.0, 3.0).asDiagonal();
  const LqRecursion recursion(stage, 20, end.inverse());
  const Vector2d start(2.0, -1.0);
  const Course best = Follow(recursion, start);
  const double smallest = Cost(stage, start, best.controls, end);
  for (Eigen::Index j = 0; j < 20; ++j) {
    for (const double change : {-0.01, 0.01}) {
      EXPECT_GT(Cost(stage, start, best.controls + change * VectorXd::Unit(20, j), end),
                smallest);
    }
  }
}

TEST(Lq, TheStageOfAnAxisIsItsIntegral) {
  for (const double alpha : {0.0, -1e-3, -0.02, -5.0, -80.0}) {
    const double stage_s = 0.01;
    const LqStage stage = AxisStage({alpha, 3.0}, {}, stage_s);
    // Midpoint steps; their error is 1e-9 of the speed.
    double x = 0.2;
    double v = 7.0;
    const double u = 40.0;
    const int count = 20000;
    const double dt = stage_s / count;
    for (int i = 0; i < count; ++i) {
      const double middle = v + 0.5 * dt * (alpha * v + 3.0 * u);
      x += dt * middle;
      v += dt * (alpha * middle + 3.0 * u);
    }
    const Vector2d next = stage.transition * Vector2d(0.2, 7.0) + stage.control * u;
    EXPECT_NEAR(next.x(), x, 1e-8);
    EXPECT_NEAR(next.y(), v, 1e-7);
  }
}

TEST(Lq, FrictionIsAWeightOfTheSpeed) {
  // alpha with weight q is no alpha with q + r alpha^2 / beta^2; of first order in the
  // stages, so a hundred times as many come a hundred times as near.
  const double alpha = -6.0;
  const double beta = 2.0;
  const AxisWeights weights{0.0, 3.0, 0.5};
  AxisWeights more = weights;
  more.speed += weights.control * alpha * alpha / (beta * beta);
  double before = 0.0;
  for (const std::size_t count : {100u, 1000u}) {
    const double stage_s = 1.0 / static_cast<double>(count);
    const Course rough = Follow(
        LqRecursion(AxisStage({alpha, beta}, weights, stage_s), count, Matrix2d::Zero()),
        {-1.0, 0.0});
    const Course smooth = Follow(
        LqRecursion(AxisStage({0.0, beta}, more, stage_s), count, Matrix2d::Zero()),
        {-1.0, 0.0});
    double off = 0.0;
    for (std::size_t j = 0; j <= count; ++j) {
      off = std::max(off, std::abs(rough.states[j].x() - smooth.states[j].x()));
    }
    EXPECT_LT(off, 0.5 * stage_s);
    if (before > 0) {
      EXPECT_LT(off, 0.2 * before);
    }
    before = off;
  }
}

}  // namespace
}  // namespace intaglio::motion
