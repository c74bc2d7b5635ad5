#include "engrave/motion/axis/lq.h"

#include <Eigen/LU>
#include <cmath>

// With u held, v tends to -beta u / alpha at the rate of alpha: over a stage d
//   v -> e v + g1 beta u,    e  = exp(alpha d),     g1 = (e - 1) / alpha
//   x -> x + g1 v + g2 beta u,                      g2 = (g1 - d) / alpha
// and g1 = d, g2 = d^2 / 2 where alpha = 0.

namespace intaglio::motion {

using Eigen::Matrix2d;
using Eigen::Vector2d;

LqRecursion::LqRecursion(const LqStage& stage, std::size_t count, const Matrix2d& end)
    : stage_(stage),
      square_(stage.control * stage.control.transpose() / stage.control_weight),
      fixed_end_(end.isZero(0.0)),
      inverses_(count + 1) {
  const Matrix2d back = stage.transition.inverse();
  inverses_[count] = end;
  for (std::size_t j = count; j-- > 0;) {
    // K[j]^-1 of Q + M^-1, which exists for a singular M as well.
    const Matrix2d m = back * (inverses_[j + 1] + square_) * back.transpose();
    const Matrix2d w = m * (Matrix2d::Identity() + stage.weight * m).inverse();
    inverses_[j] = 0.5 * (w + w.transpose());
  }
}

double LqRecursion::ControlAt(std::size_t j, const Vector2d& state) const {
  const Vector2d free = stage_.transition * state;
  // In the last stage before a fixed end u is determined by A X + B u = 0, and the sum is
  // singular.
  if (fixed_end_ && j + 1 == count()) {
    return -stage_.control.dot(free) / stage_.control.squaredNorm();
  }
  const Vector2d slope = (inverses_[j + 1] + square_).inverse() * free;
  return -stage_.control.dot(slope) / stage_.control_weight;
}

LqStage AxisStage(const AxisPlant& plant, const AxisWeights& weights, double stage_s) {
  const double product = plant.alpha_per_s * stage_s;
  double g1_s = stage_s * (1.0 + 0.5 * product);
  double g2_s2 = stage_s * stage_s * (0.5 + product / 6.0);
  // Below this the series is exact to 1e-8, and g2 as a difference is not.
  if (std::abs(product) > 1e-4) {
    g1_s = std::expm1(product) / plant.alpha_per_s;
    g2_s2 = (g1_s - stage_s) / plant.alpha_per_s;
  }
  LqStage stage;
  stage.transition << 1.0, g1_s, 0.0, std::exp(product);
  stage.control << g2_s2 * plant.beta, g1_s * plant.beta;
  stage.weight << weights.position * stage_s, 0.0, 0.0, weights.speed * stage_s;
  stage.control_weight = weights.control * stage_s;
  return stage;
}

}  // namespace intaglio::motion
