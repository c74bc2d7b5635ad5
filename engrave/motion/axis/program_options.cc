#include "engrave/motion/axis/program_options.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::motion {

double LqRatePerS(const LqPlant& plant) {
  constexpr double kMmPerM = 1000;
  Require(plant.moving_mass_kg > 0 && plant.force_weight > 0,
          "mass {} kg and weight of the force {} must be positive", plant.moving_mass_kg,
          plant.force_weight);
  Require(plant.friction_n_s_m >= 0 && plant.speed_weight >= 0,
          "friction {} N s/m and weight of the speed {} must not be negative",
          plant.friction_n_s_m, plant.speed_weight);
  const double alpha_per_s = -plant.friction_n_s_m / plant.moving_mass_kg;
  const double beta = kMmPerM / plant.moving_mass_kg;
  return std::sqrt(plant.speed_weight / plant.force_weight * beta * beta +
                   alpha_per_s * alpha_per_s);
}

}  // namespace intaglio::motion
