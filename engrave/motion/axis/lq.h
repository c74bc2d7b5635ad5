#pragma once

// Dynamic programming with squares for costs, Trochimczuk 2008 ch. 6.2.7 (88)-(98): the
// time is divided into N stages so short that each is simple, over one of which
//   X[j+1] = A X[j] + B u[j],   F = (X^T Q X + R u^2) / 2
// and Bellman's equation S(X, j) = min_u [F + S(X[j+1], j+1)] is solved from the end with
// S = X^T K[j] X / 2. That makes the discrete Riccati equation
//   K[j] = Q + A^T (K[j+1]^-1 + B R^-1 B^T)^-1 A,
// whose limit for short stages is that of (97), (98), -K' = Q + A^T K + K A - K B R^-1
// B^T K, and whose limit for N -> infinity is the stationary case (94)-(96).
//
// Kept is W = K^-1: for it the fixed end of (91), where X_T is given, is an ordinary end,
// W = 0, while K is infinite there.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace intaglio::motion {

/// One stage of two states: A, B, Q, R. A is invertible, as that of every sampled motion
/// is; Q is positive semidefinite, R > 0. Units are the caller's.
struct LqStage {
  Eigen::Matrix2d transition;   ///< A
  Eigen::Vector2d control;      ///< B
  Eigen::Matrix2d weight;       ///< Q
  double control_weight = 1.0;  ///< R
};

/// The recursion over `count` equal stages.
class LqRecursion {
 public:
  /// count >= 2. `end` is W[N]: zero for the end fixed at X = 0, else the inverse
  /// of the weight of the end, positive definite.
  LqRecursion(const LqStage& stage, std::size_t count, const Eigen::Matrix2d& end);

  std::size_t count() const { return inverses_.size() - 1; }

  /// u[j] = -R^-1 B^T K[j+1] X[j+1], j = 0..count() - 1; for a fixed end the state has to
  /// be one that reaches it. With X[j+1] = A X + B u this is
  /// K[j+1] X[j+1] = (W[j+1] + B R^-1 B^T)^-1 A X.
  double ControlAt(std::size_t j, const Eigen::Vector2d& state) const;

  Eigen::Vector2d Next(const Eigen::Vector2d& state, double control) const {
    return stage_.transition * state + stage_.control * control;
  }

 private:
  LqStage stage_;
  Eigen::Matrix2d square_;  ///< B R^-1 B^T
  bool fixed_end_;
  std::vector<Eigen::Matrix2d> inverses_;  ///< W[j] = K[j]^-1, j = 0..count()
};

/// An axis as in (38): x' = v, v' = alpha v + beta u.
struct AxisPlant {
  double alpha_per_s = 0.0;  ///< <= 0, friction
  double beta = 1.0;         ///< mm/s^2 per unit of control
};

/// The integrand of (88), F = (position x^2 + speed v^2 + control u^2) / 2.
struct AxisWeights {
  double position = 0.0;
  double speed = 0.0;
  double control = 1.0;
};

/// The axis over a stage with the control held, exactly; its cost by the value at the
/// stage's start. State (x, v) in mm and mm/s, stage_s > 0.
LqStage AxisStage(const AxisPlant& plant, const AxisWeights& weights, double stage_s);

}  // namespace intaglio::motion
