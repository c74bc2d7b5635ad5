#include "engrave/motion/lq.h"

#include <cmath>

// With u held, v tends to -beta u / alpha at the rate of alpha: over a stage d
//   v -> e v + g1 beta u,    e  = exp(alpha d),     g1 = (e - 1) / alpha
//   x -> x + g1 v + g2 beta u,                      g2 = (g1 - d) / alpha
// and g1 = d, g2 = d^2 / 2 where alpha = 0.

namespace intaglio::motion {

LqStage<2> AxisStage(const AxisPlant& plant, const AxisWeights& weights, double stage_s) {
  const double product = plant.alpha_per_s * stage_s;
  double g1_s = stage_s * (1.0 + 0.5 * product);
  double g2_s2 = stage_s * stage_s * (0.5 + product / 6.0);
  // Below this the series is exact to 1e-8, and g2 as a difference is not.
  if (std::abs(product) > 1e-4) {
    g1_s = std::expm1(product) / plant.alpha_per_s;
    g2_s2 = (g1_s - stage_s) / plant.alpha_per_s;
  }
  LqStage<2> stage;
  stage.transition << 1.0, g1_s, 0.0, std::exp(product);
  stage.control << g2_s2 * plant.beta, g1_s * plant.beta;
  stage.weight << weights.position * stage_s, 0.0, 0.0, weights.speed * stage_s;
  stage.control_weight = weights.control * stage_s;
  return stage;
}

}  // namespace intaglio::motion
