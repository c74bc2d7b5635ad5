#include "engrave/galvo/head_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/grid_sense.h"
#include "engrave/galvo/residual_surface.h"

namespace intaglio::galvo {
namespace {

using Numbers = Eigen::Matrix<double, kHeadModelNumbers, 1>;
using Normal = Eigen::Matrix<double, kHeadModelNumbers, kHeadModelNumbers>;

constexpr std::size_t kMinMarks = 16;
constexpr int kMaxIterations = 100;
// Below this share of the largest eigenvalue a number is not determined.
constexpr double kMinEigenvalue = 1e-10;
constexpr double kNormal95 = 1.96;
constexpr std::size_t kFolds = 5;
constexpr unsigned kFoldSeed = 20091;
// A mark is rejected above this many medians of all; 8 is 5.5 deviations of chance.
constexpr double kRejectedMedians = 8;
// How often its own standard error the gain of a surface has to be.
constexpr double kSignificantErrors = 2;
constexpr int kSurfaceNodes = 65;
// Steps of the numeric derivatives, by number.
constexpr std::array<double, kHeadModelNumbers> kSteps = {1e-6, 1e-6, 1e-6, 1e-5, 1e-5,
                                                          1e-5, 1e-3, 1e-3, 1e-6, 1e-5};

HeadModel ModelOf(double focal_mm, const Numbers& numbers) {
  std::array<double, kHeadModelNumbers> values;
  std::copy(numbers.begin(), numbers.end(), values.begin());
  return HeadModel::FromNumbers(focal_mm, values);
}

using Marks = std::vector<GridMark>;

double SquareSum(const HeadModel& model, const Marks& marks) {
  double sum = 0;
  for (const GridMark& mark : marks)
    sum += (mark.measured_mm - model.Arrive(mark.command_mm)).squaredNorm();
  return sum;
}

struct Equations {
  Normal normal = Normal::Zero();
  Numbers right = Numbers::Zero();
};

Equations EquationsAt(double focal_mm, const Numbers& at, const Marks& marks) {
  Equations equations;
  const HeadModel model = ModelOf(focal_mm, at);
  std::vector<HeadModel> above, below;
  for (int k = 0; k < kHeadModelNumbers; ++k) {
    const Numbers step = kSteps[static_cast<std::size_t>(k)] * Numbers::Unit(k);
    above.push_back(ModelOf(focal_mm, at + step));
    below.push_back(ModelOf(focal_mm, at - step));
  }
  for (const GridMark& mark : marks) {
    Eigen::Matrix<double, 2, kHeadModelNumbers> slope;
    for (std::size_t k = 0; k < kHeadModelNumbers; ++k) {
      slope.col(static_cast<Eigen::Index>(k)) =
          (above[k].Arrive(mark.command_mm) - below[k].Arrive(mark.command_mm)) /
          (2 * kSteps[k]);
    }
    equations.normal += slope.transpose() * slope;
    equations.right +=
        slope.transpose() * (mark.measured_mm - model.Arrive(mark.command_mm));
  }
  return equations;
}

struct Solution {
  Numbers numbers;
  Normal normal;
  double square_sum_mm2;
};

Result<Solution> Solve(double focal_mm, const Marks& marks) {
  Numbers at = Numbers::Zero();
  at[3] = at[9] = 1;
  double damping = 1e-3, sum = SquareSum(ModelOf(focal_mm, at), marks);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Equations equations = EquationsAt(focal_mm, at, marks);
    Normal damped = equations.normal;
    damped.diagonal() *= 1 + damping;
    const Numbers step = damped.ldlt().solve(equations.right);
    const double next = SquareSum(ModelOf(focal_mm, at + step), marks);
    if (!(next <= sum)) {
      damping *= 10;
      if (damping > 1e12) break;
      continue;
    }
    const bool done = sum - next <= 1e-12 * sum + 1e-24;
    at += step, sum = next, damping = std::max(damping / 10, 1e-12);
    if (done) break;
  }
  const Equations last = EquationsAt(focal_mm, at, marks);
  // By the scale of each number, so that their units do not count.
  const Numbers scale = last.normal.diagonal().cwiseSqrt();
  const Normal scaled =
      scale.cwiseInverse().asDiagonal() * last.normal * scale.cwiseInverse().asDiagonal();
  const bool of_all = scale.allFinite() && scale.minCoeff() > 0;
  const Numbers eigenvalues =
      of_all ? Eigen::SelfAdjointEigenSolver<Normal>(scaled, Eigen::EigenvaluesOnly)
                   .eigenvalues()
             : Numbers(Numbers::Zero());
  if (!(eigenvalues.minCoeff() > kMinEigenvalue * eigenvalues.maxCoeff())) {
    return Fail(ErrorCode::kInvalidValue,
                "the marks do not determine the ten numbers of the head; mark a grid "
                "over the whole field, 5 x 5 or more");
  }
  return Solution{at, last.normal, sum};
}

Status CheckMarks(std::span<const GridMark> marks, double width_mm) {
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const GridMark& mark = marks[i];
    if (!mark.command_mm.allFinite() || !mark.measured_mm.allFinite())
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("mark {} has a coordinate that is no number", i + 1));
    const double border_mm = width_mm / 2 * (1 + 1e-9);
    if (mark.command_mm.cwiseAbs().maxCoeff() > border_mm ||
        mark.measured_mm.cwiseAbs().maxCoeff() > 2 * width_mm) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("mark {}: commanded to ({:.6g}, {:.6g}) mm, measured at "
                      "({:.6g}, {:.6g}) mm, is not of a field of {:.6g} mm around "
                      "0; check field and units",
                      i + 1, mark.command_mm.x(), mark.command_mm.y(),
                      mark.measured_mm.x(), mark.measured_mm.y(), width_mm));
    }
  }
  return {};
}

std::vector<Vec2> ResidualsOf(const HeadModel& model, std::span<const GridMark> marks) {
  std::vector<Vec2> residuals;
  for (const GridMark& mark : marks)
    residuals.push_back(mark.measured_mm - model.Arrive(mark.command_mm));
  return residuals;
}

/// Marks within kRejectedMedians of the median residual.
std::vector<bool> Believed(const std::vector<Vec2>& residuals) {
  std::vector<double> sizes;
  for (const Vec2& r : residuals) sizes.push_back(r.norm());
  std::vector<double> ordered = sizes;
  const auto middle = ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2);
  std::nth_element(ordered.begin(), middle, ordered.end());
  const double limit_mm = kRejectedMedians * *middle + 1e-9;
  std::vector<bool> believed;
  for (const double size : sizes) believed.push_back(size <= limit_mm);
  return believed;
}

Marks UsedOf(std::span<const GridMark> marks, const std::vector<bool>& used) {
  Marks kept;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (used[i]) kept.push_back(marks[i]);
  return kept;
}

std::vector<PlacedVector> LeftBy(const HeadModel& model, const Marks& marks) {
  std::vector<PlacedVector> left;
  for (const GridMark& mark : marks)
    left.push_back({mark.command_mm, mark.measured_mm - model.Arrive(mark.command_mm)});
  return left;
}

/// Squares of what is left at marks that were not fitted: [0] of the numbers alone,
/// [cells] with a surface of so many cells.
struct Unseen {
  std::vector<std::vector<double>> squares_mm2;
};

/// The fold of each mark: a fixed shuffle, so that no fold is a column of the grid.
std::vector<std::size_t> FoldsOf(std::size_t count) {
  std::vector<std::size_t> folds(count);
  for (std::size_t i = 0; i < count; ++i) folds[i] = i % kFolds;
  std::mt19937 random(kFoldSeed);
  for (std::size_t i = count; i > 1; --i) std::swap(folds[i - 1], folds[random() % i]);
  return folds;
}

int MaxCells(std::size_t marks) {
  int cells = 0;
  while (cells < 16 && 3 * ResidualSurface::WeightCount(cells + 1) <=
                           2 * static_cast<int>(marks * (kFolds - 1) / kFolds))
    ++cells;
  return cells;
}

Result<Unseen> CrossValidate(const Marks& marks, const HeadFitOptions& options) {
  const int max_cells = MaxCells(marks.size());
  const std::vector<std::size_t> folds = FoldsOf(marks.size());
  Unseen unseen;
  unseen.squares_mm2.resize(static_cast<std::size_t>(max_cells) + 1);
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    Marks seen, left_out;
    for (std::size_t i = 0; i < marks.size(); ++i)
      (folds[i] == fold ? left_out : seen).push_back(marks[i]);
    const Solution solution = INTAGLIO_TRY(Solve(options.focal_mm, seen));
    const HeadModel model = ModelOf(options.focal_mm, solution.numbers);
    const auto of_seen = LeftBy(model, seen), of_left_out = LeftBy(model, left_out);
    for (int cells = 0; cells <= max_cells; ++cells) {
      std::optional<ResidualSurface> surface;
      if (cells > 0) surface.emplace(of_seen, options.width_mm, cells);
      for (const PlacedVector& v : of_left_out) {
        const Vec2 more_mm = surface ? surface->At(v.place_mm) : Vec2(Vec2::Zero());
        unseen.squares_mm2[static_cast<std::size_t>(cells)].push_back(
            (v.value_mm - more_mm).squaredNorm());
      }
    }
  }
  return unseen;
}

double MeanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(values.size());
}

/// Whether the second squares are smaller by more than chance.
bool IsSignificant(const std::vector<double>& first, const std::vector<double>& second) {
  std::vector<double> gains;
  for (std::size_t i = 0; i < first.size(); ++i) gains.push_back(first[i] - second[i]);
  const double mean = MeanOf(gains);
  double square = 0;
  for (const double gain : gains) square += (gain - mean) * (gain - mean);
  const auto count = static_cast<double>(gains.size());
  return mean > kSignificantErrors * std::sqrt(square / (count * (count - 1)));
}

Status AddSurface(const Marks& marks, const HeadFitOptions& options, HeadFit& fit) {
  const Unseen unseen = INTAGLIO_TRY(CrossValidate(marks, options));
  std::size_t best = 0;
  for (std::size_t cells = 1; cells < unseen.squares_mm2.size(); ++cells) {
    if (best == 0 || MeanOf(unseen.squares_mm2[cells]) < MeanOf(unseen.squares_mm2[best]))
      best = cells;
  }
  const auto rms_mm = [&](std::size_t cells) {
    return std::sqrt(MeanOf(unseen.squares_mm2[cells]) / 2);
  };
  fit.unseen_rms_mm = rms_mm(0);
  fit.unseen_rms_with_surface_mm = rms_mm(best);
  if (best == 0 || !IsSignificant(unseen.squares_mm2[0], unseen.squares_mm2[best]))
    return {};
  fit.surface_cells = static_cast<int>(best);
  const ResidualSurface surface(LeftBy(fit.model, marks), options.width_mm,
                                fit.surface_cells);
  fit.surface = CentredGrid(options.width_mm, kSurfaceNodes);
  for (int j = 0; j < kSurfaceNodes; ++j)
    for (int i = 0; i < kSurfaceNodes; ++i)
      fit.surface.values_mm[fit.surface.IndexOf(i, j)] =
          surface.At(fit.surface.PlaceOf(i, j));
  return {};
}

/// Subtracts the surface from the residuals; the standard deviation of what is left.
double SigmaOf(std::span<const GridMark> marks, HeadFit& fit) {
  double degrees = -kHeadModelNumbers, square_mm2 = 0;
  std::optional<CorrectionTable> surface;
  if (fit.surface_cells > 0) {
    surface = CorrectionTable::Make(fit.surface, Interpolation::kSpline).value();
    degrees -= 2 * ResidualSurface::WeightCount(fit.surface_cells);
  }
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (surface) fit.residuals_mm[i] -= surface->At(marks[i].command_mm);
    if (!fit.used[i]) continue;
    square_mm2 += fit.residuals_mm[i].squaredNorm();
    degrees += 2;
  }
  return std::sqrt(square_mm2 / degrees);
}

}  // namespace

Result<HeadFit> FitHead(std::span<const GridMark> marks, const HeadFitOptions& options) {
  Require(options.width_mm > 0 && options.focal_mm > 0, "a field of {} mm, {} mm/rad",
          options.width_mm, options.focal_mm);
  INTAGLIO_TRY(CheckMarks(marks, options.width_mm));
  INTAGLIO_TRY(CheckGridSense(marks));
  HeadFit fit;
  fit.used.assign(marks.size(), true);
  Marks used;
  Solution solution{};
  for (int round = 0; round < 3; ++round) {  // a far mark pulls at the first fit
    used = UsedOf(marks, fit.used);
    if (used.size() < kMinMarks) {
      return Fail(
          ErrorCode::kMissing,
          fmt::format("{} {} too few to fit a head; measure {} or more over the "
                      "whole field",
                      Counted(used.size(), "mark"), IsOrAre(used.size()), kMinMarks),
          fmt::format("{}", used.size()));
    }
    solution = INTAGLIO_TRY(Solve(options.focal_mm, used));
    fit.model = ModelOf(options.focal_mm, solution.numbers);
    fit.residuals_mm = ResidualsOf(fit.model, marks);
    const std::vector<bool> believed = Believed(fit.residuals_mm);
    if (round == 2 || believed == fit.used) break;
    fit.used = believed;
  }
  INTAGLIO_TRY(AddSurface(used, options, fit));
  const Normal inverse = solution.normal.inverse();
  fit.sigma_mm = SigmaOf(marks, fit);
  for (int k = 0; k < kHeadModelNumbers; ++k) {
    fit.interval95[static_cast<std::size_t>(k)] =
        kNormal95 * fit.sigma_mm * std::sqrt(inverse(k, k));
  }
  INTAGLIO_TRY(CheckFitSense(fit, options.width_mm));
  return fit;
}

namespace {

std::optional<CorrectionTable> SurfaceOf(const HeadFit& fit) {
  if (fit.surface_cells == 0) return std::nullopt;
  return CorrectionTable::Make(fit.surface, Interpolation::kSpline).value();
}

Vec2 ArrivalBy(const HeadFit& fit, const std::optional<CorrectionTable>& surface,
               const Vec2& command_mm) {
  const Vec2 by_model_mm = fit.model.Arrive(command_mm);
  return surface ? Vec2(by_model_mm + surface->At(command_mm)) : by_model_mm;
}

}  // namespace

Vec2 ArrivalOf(const HeadFit& fit, const Vec2& command_mm) {
  return ArrivalBy(fit, SurfaceOf(fit), command_mm);
}

FieldGrid DeviationsOf(const HeadFit& fit, double width_mm, int nodes) {
  FieldGrid grid = CentredGrid(width_mm, nodes);
  const auto surface = SurfaceOf(fit);
  for (int j = 0; j < nodes; ++j) {
    for (int i = 0; i < nodes; ++i) {
      const Vec2 command_mm = grid.PlaceOf(i, j);
      grid.values_mm[grid.IndexOf(i, j)] =
          ArrivalBy(fit, surface, command_mm) - command_mm;
    }
  }
  return grid;
}

}  // namespace intaglio::galvo
