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

#include <Eigen/Dense>
#include <cstddef>
#include <vector>

namespace intaglio::motion {

/// One stage: A, B, Q, R. A is invertible, as that of every sampled motion is; Q is
/// positive semidefinite, R > 0. Units are the caller's.
template <int kStates>
struct LqStage {
  Eigen::Matrix<double, kStates, kStates> transition;  ///< A
  Eigen::Matrix<double, kStates, 1> control;           ///< B
  Eigen::Matrix<double, kStates, kStates> weight;      ///< Q
  double control_weight = 1.0;                         ///< R
};

/// The recursion over `count` equal stages.
template <int kStates>
class LqRecursion {
 public:
  using Matrix = Eigen::Matrix<double, kStates, kStates>;
  using Vector = Eigen::Matrix<double, kStates, 1>;

  /// count >= kStates. `end` is W[N]: zero for the end fixed at X = 0, else the inverse
  /// of the weight of the end, positive definite.
  LqRecursion(const LqStage<kStates>& stage, std::size_t count, const Matrix& end)
      : stage_(stage),
        square_(stage.control * stage.control.transpose() / stage.control_weight),
        fixed_end_(end.isZero(0.0)),
        inverses_(count + 1) {
    const Matrix back = stage.transition.inverse();
    inverses_[count] = end;
    for (std::size_t j = count; j-- > 0;) {
      // K[j]^-1 of Q + M^-1, which exists for a singular M as well.
      const Matrix m = back * (inverses_[j + 1] + square_) * back.transpose();
      const Matrix w = m * (Matrix::Identity() + stage.weight * m).inverse();
      inverses_[j] = 0.5 * (w + w.transpose());
    }
  }

  std::size_t count() const { return inverses_.size() - 1; }
  /// W[j] = K[j]^-1, j = 0..count().
  const Matrix& InverseAt(std::size_t j) const { return inverses_[j]; }

  /// u[j] = -R^-1 B^T K[j+1] X[j+1], j = 0..count() - 1; for a fixed end the state has to
  /// be one that reaches it. With X[j+1] = A X + B u this is
  /// K[j+1] X[j+1] = (W[j+1] + B R^-1 B^T)^-1 A X.
  double ControlAt(std::size_t j, const Vector& state) const {
    const Matrix sum = inverses_[j + 1] + square_;
    const Vector free = stage_.transition * state;
    // Few stages before a fixed end not every state reaches it: the sum is singular,
    // but A X lies in its range.
    const bool singular = fixed_end_ && count() - j < kStates;
    const Vector slope = singular
                             ? Vector(sum.completeOrthogonalDecomposition().solve(free))
                             : Vector(sum.inverse() * free);
    return -stage_.control.dot(slope) / stage_.control_weight;
  }

  Vector Next(const Vector& state, double control) const {
    return stage_.transition * state + stage_.control * control;
  }

 private:
  LqStage<kStates> stage_;
  Matrix square_;  ///< B R^-1 B^T
  bool fixed_end_;
  std::vector<Matrix> inverses_;
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
LqStage<2> AxisStage(const AxisPlant& plant, const AxisWeights& weights, double stage_s);

}  // namespace intaglio::motion
