#include "engrave/drive/identification.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/drive/drive_kinds.h"

// Levenberg-Marquardt (Marquardt 1963) over the logarithms of the parameters, for they
// are positive and span decades; those whose range includes 0 are taken as they are. It
// begins at the best place of a coarse grid over the ranges. The covariance is s^2 (J^T
// J)^-1, s^2 the residual's variance, and 1.96 its half-width (Seber and Wild, Nonlinear
// Regression, 1989, ch. 2).

namespace intaglio::drive {
namespace {

using Vector = Eigen::VectorXd;

constexpr int kMaxIterations = 60;
constexpr double kNormal95 = 1.96;
constexpr double kStep = 1e-5;  // of a numeric derivative, of 1 in the logarithm
// Grid points of all parameters together.
constexpr double kGridPoints = 3000;

tl::unexpected<Error> WrongRecord(std::string text) {
  return Fail(ErrorCode::kInvalidValue, std::move(text));
}

Status CheckSamples(std::span<const DriveSample> record) {
  for (std::size_t i = 0; i < record.size(); ++i) {
    const DriveSample& s = record[i];
    if (!std::isfinite(s.time_s) || !std::isfinite(s.command_u) ||
        !std::isfinite(s.position_u))
      return WrongRecord(fmt::format("sample {}: {} s, {}, {} are not all numbers", i,
                                     s.time_s, s.command_u, s.position_u));
    if (i > 0 && !(s.time_s > record[i - 1].time_s))
      return WrongRecord(fmt::format("sample {}: its time {} s is not behind {} s", i,
                                     s.time_s, record[i - 1].time_s));
  }
  return {};
}

Status CheckSteps(std::span<const DriveStep> steps) {
  const auto measured = std::ranges::count_if(
      steps, [](const DriveStep& step) { return step.position_u.has_value(); });
  // The first sample of a record is where the axis rests.
  if (measured < 9) {
    const std::uint64_t count =
        steps.empty() ? 0 : static_cast<std::uint64_t>(measured) + 1;
    return WrongRecord(fmt::format("{} {} too few to identify a drive; record 10 or more",
                                   Counted(count, "sample"), IsOrAre(count)));
  }
  const bool moves = std::ranges::any_of(steps, [](const DriveStep& step) {
    const Cubic& c = step.command;
    return c.velocity_u_s != 0 || c.acceleration_u_s2 != 0 || c.jerk_u_s3 != 0;
  });
  if (!moves) return WrongRecord("the command does not move; record a step or a move");
  return {};
}

class Fit {
 public:
  Fit(const DriveKind& kind, std::span<const DriveStep> steps)
      : kind_(kind), steps_(steps) {
    for (const DriveStep& step : steps) measured_ += step.position_u ? 1 : 0;
  }

  std::size_t size() const { return kind_.parameters.size(); }
  bool IsLog(std::size_t i) const { return kind_.parameters[i].min > 0; }
  double Low(std::size_t i) const {
    return IsLog(i) ? std::log(kind_.parameters[i].min) : kind_.parameters[i].min;
  }
  double High(std::size_t i) const {
    return IsLog(i) ? std::log(kind_.parameters[i].max) : kind_.parameters[i].max;
  }
  std::vector<double> ValuesOf(const Vector& at) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < size(); ++i) {
      const double x = at[static_cast<Eigen::Index>(i)];
      values.push_back(std::clamp(IsLog(i) ? std::exp(x) : x, kind_.parameters[i].min,
                                  kind_.parameters[i].max));
    }
    return values;
  }
  Vector Bounded(Vector at) const {
    for (std::size_t i = 0; i < size(); ++i) {
      double& x = at[static_cast<Eigen::Index>(i)];
      x = std::clamp(x, Low(i), High(i));
    }
    return at;
  }

  /// Model minus record at each measured position.
  Vector Residuals(const Vector& at) const {
    const auto drive = kind_.make(ValuesOf(at));
    Vector residuals(measured_);
    Eigen::Index row = 0;
    AxisState state = drive->SettledState({steps_.front().command.position_u, 0, 0, 0});
    for (const DriveStep& step : steps_) {
      state = drive->Follow(state, step.command, step.duration_s);
      if (step.position_u) residuals[row++] = state.position_u - *step.position_u;
    }
    return residuals;
  }

  Eigen::MatrixXd Jacobian(const Vector& at) const {
    Eigen::MatrixXd jacobian(measured_, at.size());
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      Vector up = at, down = at;
      up[i] += kStep, down[i] -= kStep;
      up = Bounded(up), down = Bounded(down);
      jacobian.col(i) = (Residuals(up) - Residuals(down)) / (up[i] - down[i]);
    }
    return jacobian;
  }

  /// The best place of a grid.
  Vector Begin() const {
    const int a_side = std::max(
        2, static_cast<int>(std::pow(kGridPoints, 1 / static_cast<double>(size()))));
    int count = 1;
    for (std::size_t i = 0; i < size(); ++i) count *= a_side;
    Vector best;
    double smallest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < count; ++k) {
      Vector at(static_cast<Eigen::Index>(size()));
      int left = k;
      for (std::size_t i = 0; i < size(); ++i, left /= a_side) {
        const double ratio = (left % a_side + 0.5) / a_side;
        at[static_cast<Eigen::Index>(i)] = Low(i) + ratio * (High(i) - Low(i));
      }
      const double cost = Residuals(at).squaredNorm();
      if (cost < smallest) smallest = cost, best = at;
    }
    return best;
  }

 private:
  const DriveKind& kind_;
  std::span<const DriveStep> steps_;
  Eigen::Index measured_ = 0;
};

/// Steps until nothing is gained; the number of them.
int Descend(const Fit& fit, Vector& at) {
  double cost = fit.Residuals(at).squaredNorm(), damping = 1e-3;
  for (int iteration = 1; iteration <= kMaxIterations; ++iteration) {
    const Eigen::MatrixXd jacobian = fit.Jacobian(at);
    const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Vector gradient = jacobian.transpose() * fit.Residuals(at);
    bool gained = false;
    while (!gained && damping < 1e12) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-300;
      const Vector next = fit.Bounded(at - damped.ldlt().solve(gradient));
      const double next_cost = fit.Residuals(next).squaredNorm();
      gained = next_cost < cost;
      if (!gained) {
        damping *= 10;
        continue;
      }
      const bool small = cost - next_cost < 1e-12 * cost;
      at = next, cost = next_cost, damping = std::max(1e-12, damping / 10);
      if (small) return iteration;
    }
    if (!gained) return iteration;
  }
  return kMaxIterations;
}

Result<Identification> Finish(const DriveKind& kind, const Fit& fit, const Vector& at,
                              int iterations) {
  const Eigen::MatrixXd jacobian = fit.Jacobian(at);
  const Vector residuals = fit.Residuals(at);
  const auto freedom = static_cast<double>(residuals.size() - at.size());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian.transpose() * jacobian,
                                              Eigen::ComputeFullV);
  const auto& singular = svd.singularValues();
  if (!(singular[singular.size() - 1] > 1e-14 * singular[0]) || freedom < 1) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the record does not determine the parameters of {}; record "
                            "a faster move, or sample it more often",
                            kind.name));
  }
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse() * residuals.squaredNorm() / freedom;
  Identification found;
  found.iterations = iterations;
  found.rms_residual_u =
      std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
  const std::vector<double> values = fit.ValuesOf(at);
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(std::max(0.0, covariance(k, k)));
    found.parameters.push_back({kind.parameters[i].name, values[i],
                                kNormal95 * deviation * (fit.IsLog(i) ? values[i] : 1)});
  }
  return found;
}

}  // namespace

Result<std::vector<DriveStep>> StepsOf(std::span<const DriveSample> record) {
  INTAGLIO_TRY(CheckSamples(record));
  std::vector<DriveStep> steps;
  for (std::size_t i = 1; i < record.size(); ++i) {
    const DriveSample &from = record[i - 1], &to = record[i];
    const double duration_s = to.time_s - from.time_s;
    const double slope = (to.command_u - from.command_u) / duration_s;
    steps.push_back({{from.command_u, slope}, duration_s, to.position_u});
  }
  return steps;
}

Result<Identification> Identify(std::string_view name,
                                std::span<const DriveSample> record) {
  const auto steps = INTAGLIO_TRY(StepsOf(record));
  return Identify(name, std::span<const DriveStep>(steps));
}

Result<Identification> Identify(std::string_view name, std::span<const DriveStep> steps) {
  std::string known;
  for (const DriveKind& kind : DriveKinds()) {
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
    if (kind.name != name) continue;
    INTAGLIO_TRY(CheckSteps(steps));
    const Fit fit(kind, steps);
    Vector at = fit.Begin();
    const int iterations = Descend(fit, at);
    return Finish(kind, fit, at, iterations);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("drive {}: no such drive; known: {}", name, known),
              std::string(name));
}

}  // namespace intaglio::drive
