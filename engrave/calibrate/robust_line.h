#pragma once

// Linear least squares that leaves outliers out.

#include <Eigen/Core>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::calibrate {

struct RobustSolution {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  double deviation = 0;    ///< standard deviation of a row's residual
  int degrees = 0;         ///< rows that were used minus unknowns
  std::vector<bool> used;  ///< one a row
};

/// A x = b, one row a measurement. Outliers are rows farther than five standard
/// deviations from the solution of the others; what may be farther is at most a third of
/// the rows. kMissing: the rows do not determine all unknowns; its value is the number of
/// an unknown that they do not determine.
Result<RobustSolution> SolveRobustly(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// The factor of a standard deviation for a two-sided interval of 95 % (Student;
/// Abramowitz and Stegun 1964, 26.7.5), `degrees` >= 3.
double Student95(int degrees);

}  // namespace intaglio::calibrate
