#include "engrave/course/linear_program.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

// With slacks s = b - A x > 0 and multipliers z > 0 the optimum has A' z = c and s z = 0.
// A Newton step of these equations, with the residuals
//   rp = b - A x - s,  rd = c - A' z,  rc = target - s z,
// leaves dx alone:  A' D A dx = A' (rc - z rp) / s - rd  with the sign of dz = (rc - z
// ds) / s and ds = rp - A dx,  D = z / s.

namespace intaglio::course {
namespace {

using Vector = Eigen::VectorXd;

constexpr int kMaxSteps = 60;
constexpr double kResidualRatio = 1e-6, kGapRatio = 1e-5;
/// The multipliers grow without bound when no point keeps the limits.
constexpr double kNoPointGap = 1e9;
/// A step ends this far before a slack or a multiplier is zero.
constexpr double kStepShare = 0.995;

double LongestStep(const Vector& value, const Vector& change) {
  double step = 1;
  for (Eigen::Index i = 0; i < value.size(); ++i)
    if (change[i] < 0) step = std::min(step, -kStepShare * value[i] / change[i]);
  return step;
}

struct Point {
  Vector x, s, z;
};

class Newton {
 public:
  Newton(const LinearProgram& program, const Point& at)
      : a_(program.rows), at_(at), weights_(at.z.cwiseQuotient(at.s)) {
    // The lower half alone, which is what the factors are made of.
    const Eigen::MatrixXd scaled = weights_.cwiseSqrt().asDiagonal() * a_;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(a_.cols(), a_.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
    normal.diagonal().array() += 1e-13 * normal.diagonal().maxCoeff();
    factors_.compute(normal);
    primal_ = program.limits - a_ * at.x - at.s;
    dual_ = program.gain - a_.transpose() * at.z;
  }

  Point Step(const Vector& target) const {
    const Vector complement = target - at_.s.cwiseProduct(at_.z);
    const Vector pull = (complement - at_.z.cwiseProduct(primal_)).cwiseQuotient(at_.s);
    Point step;
    step.x = factors_.solve(dual_ - a_.transpose() * pull);
    step.s = primal_ - a_ * step.x;
    step.z = (complement - at_.z.cwiseProduct(step.s)).cwiseQuotient(at_.s);
    return step;
  }

  double primal() const { return primal_.lpNorm<Eigen::Infinity>(); }
  double dual() const { return dual_.lpNorm<Eigen::Infinity>(); }

 private:
  const Eigen::MatrixXd& a_;
  const Point& at_;
  Vector weights_, primal_, dual_;
  Eigen::LLT<Eigen::MatrixXd> factors_;
};

}  // namespace

std::optional<Vector> Maximize(const LinearProgram& program) {
  const auto count = static_cast<double>(program.limits.size());
  Point at;
  at.x = Vector::Zero(program.gain.size());
  at.s = program.limits.cwiseAbs().cwiseMax(1);
  at.z = Vector::Ones(program.limits.size());
  const double limit_size = 1 + program.limits.lpNorm<Eigen::Infinity>();
  const double gain_size = 1 + program.gain.lpNorm<Eigen::Infinity>();
  for (int i = 0; i < kMaxSteps; ++i) {
    const Newton newton(program, at);
    const double gap = at.s.dot(at.z) / count;
    if (!(gap * count <= kNoPointGap)) return std::nullopt;
    if (newton.primal() <= kResidualRatio * limit_size &&
        newton.dual() <= kResidualRatio * gain_size &&
        gap * count <= kGapRatio * (1 + std::abs(program.gain.dot(at.x))))
      return at.x;
    const Point guess = newton.Step(Vector::Zero(at.s.size()));
    const double primal_step = LongestStep(at.s, guess.s);
    const double dual_step = LongestStep(at.z, guess.z);
    const double reached =
        (at.s + primal_step * guess.s).dot(at.z + dual_step * guess.z) / count;
    const double centering = std::pow(reached / gap, 3);
    const Vector target =
        Vector::Constant(at.s.size(), centering * gap) - guess.s.cwiseProduct(guess.z);
    const Point step = newton.Step(target);
    const double along = LongestStep(at.s, step.s);
    at.x += along * step.x;
    at.s += along * step.s;
    at.z += LongestStep(at.z, step.z) * step.z;
  }
  return std::nullopt;
}

}  // namespace intaglio::course
