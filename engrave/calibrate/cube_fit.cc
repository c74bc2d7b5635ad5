#include "engrave/calibrate/cube_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "engrave/calibrate/robust_line.h"
#include "engrave/core/try.h"
#include "engrave/machine/scan_head.h"

// Newton's method for least squares; each step is solved robustly and halved until the
// rows that it uses fit better. The slope of depth by 1/L is 0 at a telecentric lens, so
// the search begins at a distance of 300 mm at most. Then unknowns are given up one by
// one, the least significant first, and the others are fitted again: an unknown that
// keeps a value that it does not have would bend those that hang together with it.

namespace intaglio::calibrate {
namespace {

constexpr double kFirstPupil = 1.0 / 300;
constexpr int kMaxNewtonSteps = 60, kMaxHalvings = 12;
constexpr double kConvergedMm = 1e-8;
// Share of a column that the columns before it do not have, below which it is theirs.
constexpr double kRankShare = 1e-6;
// An unknown that may move a mark by more than this is not determined.
constexpr double kVagueMm = 0.3;

/// Small enough for a derivative by differences of a place of tens of mm.
double StepOf(int unknown) {
  switch (unknown) {
    case kOriginX:
    case kOriginY:
    case kTop:
      return 1e-3;
    case kPupilX:
    case kPupilY:
      return 1e-7;
    default:
      return 1e-5;
  }
}

struct Row {
  std::size_t mark = 0;
  int axis = 0;
};

struct Solved {
  HeadState head;
  RobustSolution step;         // of the last, whose step is nearly 0
  std::vector<double> effect;  // of each free unknown on a mark, at most
};

class Fitter {
 public:
  Fitter(const std::vector<CubeMark>& marks, const CubeFrame& frame)
      : marks_(marks), frame_(frame) {
    for (std::size_t i = 0; i < marks.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(marks[i].measured_mm[axis])) rows_.push_back({i, axis});
      }
    }
  }

  const std::vector<Row>& rows() const { return rows_; }

  Eigen::VectorXd Residuals(const HeadState& head) const {
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const CubeMark& mark = marks_[rows_[r].mark];
      residuals[static_cast<Eigen::Index>(r)] =
          mark.measured_mm[rows_[r].axis] - PlaceOf(head, mark, frame_)[rows_[r].axis];
    }
    return residuals;
  }

  /// Derivatives of the coordinates of all marks by an unknown: one mark a column.
  Eigen::Matrix3Xd PlaceSlopes(const HeadState& head, int unknown) const {
    HeadState up = head, down = head;
    up[static_cast<std::size_t>(unknown)] += StepOf(unknown);
    down[static_cast<std::size_t>(unknown)] -= StepOf(unknown);
    Eigen::Matrix3Xd slopes(3, static_cast<Eigen::Index>(marks_.size()));
    for (std::size_t i = 0; i < marks_.size(); ++i) {
      slopes.col(static_cast<Eigen::Index>(i)) =
          (PlaceOf(up, marks_[i], frame_) - PlaceOf(down, marks_[i], frame_)) /
          (2 * StepOf(unknown));
    }
    return slopes;
  }

  /// Those of the measured coordinates.
  Eigen::VectorXd OfRows(const Eigen::Matrix3Xd& slopes) const {
    Eigen::VectorXd column(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      column[static_cast<Eigen::Index>(r)] =
          slopes(rows_[r].axis, static_cast<Eigen::Index>(rows_[r].mark));
    }
    return column;
  }

  /// The unknowns of `asked` that the rows determine, in order.
  std::vector<int> Determined(const HeadState& head,
                              const std::vector<int>& asked) const {
    std::vector<int> determined;
    std::vector<Eigen::VectorXd> basis;
    for (const int unknown : asked) {
      Eigen::VectorXd column = OfRows(PlaceSlopes(head, unknown));
      const double norm = column.norm();
      for (int round = 0; round < 2; ++round) {
        for (const Eigen::VectorXd& unit : basis) column -= unit.dot(column) * unit;
      }
      if (!(column.norm() > kRankShare * norm)) continue;
      basis.push_back(column.normalized());
      determined.push_back(unknown);
    }
    return determined;
  }

  Result<Solved> Solve(HeadState head, const std::vector<int>& unknowns) const {
    Solved solved;
    for (int step = 0; step < kMaxNewtonSteps; ++step) {
      const Eigen::VectorXd b = Residuals(head);
      Eigen::MatrixXd a(b.size(), static_cast<Eigen::Index>(unknowns.size()));
      solved.effect.clear();
      for (std::size_t c = 0; c < unknowns.size(); ++c) {
        const Eigen::Matrix3Xd slopes = PlaceSlopes(head, unknowns[c]);
        a.col(static_cast<Eigen::Index>(c)) = OfRows(slopes);
        solved.effect.push_back(slopes.cwiseAbs().maxCoeff());
      }
      auto solution = SolveRobustly(a, b);
      if (!solution) {
        return Fail(ErrorCode::kMissing,
                    "there are too few coordinates; measure x, y and z of at least ten "
                    "marks, at every level and at the corners of the cube");
      }
      solved.step = std::move(*solution);
      if (!Advance(b, unknowns, solved, head)) break;
    }
    solved.head = head;
    return solved;
  }

 private:
  /// False: it has converged.
  bool Advance(const Eigen::VectorXd& before, const std::vector<int>& unknowns,
               const Solved& solved, HeadState& head) const {
    double largest_mm = 0;
    for (std::size_t c = 0; c < unknowns.size(); ++c) {
      const double by = solved.step.values[static_cast<Eigen::Index>(c)];
      largest_mm = std::max(largest_mm, solved.effect[c] * std::abs(by));
    }
    if (largest_mm < kConvergedMm) return false;
    const auto squares = [&](const Eigen::VectorXd& residuals) {
      double sum = 0;
      for (std::size_t r = 0; r < solved.step.used.size(); ++r) {
        const double residual = residuals[static_cast<Eigen::Index>(r)];
        if (solved.step.used[r]) sum += residual * residual;
      }
      return sum;
    };
    double share = 1;
    for (int i = 0; i < kMaxHalvings; ++i, share /= 2) {
      HeadState tried = head;
      for (std::size_t c = 0; c < unknowns.size(); ++c) {
        tried[static_cast<std::size_t>(unknowns[c])] +=
            share * solved.step.values[static_cast<Eigen::Index>(c)];
      }
      const double now = squares(Residuals(tried));
      if (!(now < squares(before))) continue;
      head = tried;
      return true;
    }
    return false;
  }

  const std::vector<CubeMark>& marks_;
  CubeFrame frame_;
  std::vector<Row> rows_;
};

bool IsHeld(int unknown, KnownOfHead held) {
  switch (unknown) {
    case kIndex:
      return held == KnownOfHead::kIndex;
    case kZRatio:
      return held == KnownOfHead::kZ;
    case kPupilX:
    case kPupilY:
      return held == KnownOfHead::kPupil;
    default:
      return false;
  }
}

/// The mirrors' places are found by driving there: they are always what was measured.
bool IsPlace(int unknown) {
  return unknown == kOriginX || unknown == kOriginY || unknown == kTop;
}

/// The place in `unknowns` of the one to give up; -1: none.
int WeakestOf(const std::vector<int>& unknowns, const HeadState& known,
              std::array<HeadFigure, kHeadUnknowns>& figures, const Solved& solved) {
  int weakest = -1;
  double smallest = 1;
  for (std::size_t c = 0; c < unknowns.size(); ++c) {
    const auto unknown = static_cast<std::size_t>(unknowns[c]);
    HeadFigure& found = figures[unknown];
    const double interval = found.figure.interval95;
    const bool vague = interval * solved.effect[c] > kVagueMm;
    found.state = vague ? FigureState::kUndetermined : FigureState::kFound;
    const double difference = std::abs(solved.head[unknown] - known[unknown]);
    const double significance = interval > 0 ? difference / interval : 2;
    if (vague ? significance / 1e3 < smallest
              : !IsPlace(unknowns[c]) && significance < smallest) {
      smallest = vague ? significance / 1e3 : significance;
      weakest = static_cast<int>(c);
    }
  }
  if (weakest < 0) return weakest;
  HeadFigure& given_up =
      figures[static_cast<std::size_t>(unknowns[static_cast<std::size_t>(weakest)])];
  if (given_up.state == FigureState::kFound) given_up.state = FigureState::kAsKnown;
  return weakest;
}

void SetIntervals(const std::vector<int>& unknowns, const Solved& solved,
                  std::array<HeadFigure, kHeadUnknowns>& figures) {
  const double factor = Student95(solved.step.degrees);
  for (std::size_t c = 0; c < unknowns.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(c);
    const auto unknown = static_cast<std::size_t>(unknowns[c]);
    figures[unknown].figure = {solved.head[unknown],
                               factor * std::sqrt(solved.step.covariance(at, at))};
  }
}

void AddResiduals(const Fitter& fitter, const Solved& solved, std::size_t marks,
                  CubeFit& fit) {
  fit.deviation_mm = solved.step.deviation;
  fit.coordinate_count = static_cast<int>(fitter.rows().size());
  fit.residuals_mm.assign(marks, Vec3::Zero());
  const Eigen::VectorXd residuals = fitter.Residuals(solved.head);
  for (std::size_t r = 0; r < fitter.rows().size(); ++r) {
    const Row& row = fitter.rows()[r];
    fit.residuals_mm[row.mark][row.axis] = residuals[static_cast<Eigen::Index>(r)];
    if (solved.step.used[r]) continue;
    if (fit.strays.empty() || fit.strays.back() != row.mark) {
      fit.strays.push_back(row.mark);
    }
  }
}

}  // namespace

Vec3 PlaceOf(const HeadState& head, const CubeMark& mark, const CubeFrame& frame) {
  const Vec2 in_field_mm = machine::FieldMatrix(head[kXScale], head[kYScale],
                                                head[kSquareness], head[kRotation]) *
                           mark.field_mm;
  const Vec2 tilt(head[kTiltX], head[kTiltY]), lean(head[kLeanX], head[kLeanY]);
  const double below_mm = head[kTop] - head[kZRatio] * mark.z_mm;
  const Vec2 u_mm = in_field_mm - below_mm * lean;
  const double h_mm = below_mm + tilt.dot(u_mm);
  const Vec2 slopes = in_field_mm.cwiseProduct(Vec2(head[kPupilX], head[kPupilY])) - tilt;
  const double n = head[kIndex];
  const double q = slopes.squaredNorm() * (1 - 1 / (n * n));
  const double depth_mm = frame.depth_ratio * n * h_mm * std::sqrt(1 + q) * (1 + 0.5 * q);
  const Vec2 across_mm = u_mm - below_mm * tilt + 0.5 * h_mm * q * slopes -
                         Vec2(head[kOriginX], head[kOriginY]);
  return {across_mm.x(), across_mm.y(), frame.block_height_mm - depth_mm};
}

Result<CubeFit> FitCube(const std::vector<CubeMark>& marks, const HeadState& known,
                        const CubeFrame& frame, KnownOfHead held) {
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].field_mm.allFinite() && std::isfinite(marks[i].z_mm)) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("mark {} has a command that is no number", i + 1));
  }
  const Fitter fitter(marks, frame);
  CubeFit fit;
  HeadState start = known;
  std::vector<int> asked;
  for (int unknown = 0; unknown < kHeadUnknowns; ++unknown) {
    const auto at = static_cast<std::size_t>(unknown);
    fit.figures[at].figure = {known[at], 0};
    if (IsHeld(unknown, held)) continue;
    fit.figures[at].state = FigureState::kUndetermined;
    asked.push_back(unknown);
    if (unknown == kPupilX || unknown == kPupilY)
      start[at] = std::max(known[at], kFirstPupil);
  }
  std::vector<int> unknowns = fitter.Determined(start, asked);
  for (const int unknown : asked) {
    if (std::ranges::find(unknowns, unknown) == unknowns.end())
      start[static_cast<std::size_t>(unknown)] = known[static_cast<std::size_t>(unknown)];
  }
  for (;;) {
    const Solved solved = INTAGLIO_TRY(fitter.Solve(start, unknowns));
    SetIntervals(unknowns, solved, fit.figures);
    const int weakest = WeakestOf(unknowns, known, fit.figures, solved);
    if (weakest < 0) {
      AddResiduals(fitter, solved, marks.size(), fit);
      return fit;
    }
    const auto unknown =
        static_cast<std::size_t>(unknowns[static_cast<std::size_t>(weakest)]);
    fit.figures[unknown].figure.value = known[unknown];
    start = solved.head;
    start[unknown] = known[unknown];
    unknowns.erase(unknowns.begin() + weakest);
  }
}

}  // namespace intaglio::calibrate
