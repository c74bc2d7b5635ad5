#pragma once

// A small dense linear program: find x of greatest c x with A x <= b. By Mehrotra's
// predictor-corrector method, whose path is the same for the same numbers, and which
// ends inside the set of optimal points, away from its corners, where a simplex would
// end in one of them.
//
// Source: Mehrotra 1992, On the implementation of a primal-dual interior point method,
// for the form with inequalities alone (Nocedal and Wright, Numerical Optimization, 14).

#include <Eigen/Core>
#include <optional>

namespace intaglio::course {

struct LinearProgram {
  Eigen::MatrixXd rows;    ///< A: a constraint a row; of full column rank
  Eigen::VectorXd limits;  ///< b
  Eigen::VectorXd gain;    ///< c
};

/// To 1e-5 of the gain and 1e-6 of the limits' size. None when there is no point within
/// the limits, or the gain has no bound. Time: rows x columns^2 for each of at most 60
/// steps.
std::optional<Eigen::VectorXd> Maximize(const LinearProgram& program);

}  // namespace intaglio::course
