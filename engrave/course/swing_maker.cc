#include "engrave/course/swing_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engrave/course/linear_program.h"

// With d0 and d1 the legs' directions, v the speed at the corner and w the swing, the
// reference is  d (v t + a m (|t| - m / 2) sign(t)) + w(t),  m = min(|t|, t_c),  d = d0
// before, d1 behind, t_c = (feed - v) / a, after which the speed is constant. Kernel and
// motor are linear and act on each axis alone, so what a hat of the swing does is
// computed once and moved from knot to knot.
//
// Each setpoint has its rows: the motor of a hat has steps, and a program that sees each
// third setpoint leaves 16 % too much between them.

namespace intaglio::course {
namespace {

using Samples = std::vector<double>;

constexpr std::size_t kKnotsPerHalf = 10;
constexpr int kCircleSides = 16;
/// A speed is found when its least load is between this ratio and 1.
constexpr double kNearRatio = 0.98;
/// The share of a speed that changes the load by its own ratio, about, and the most of
/// one step.
constexpr double kRatioChange = 2, kMaxFall = 0.7, kMaxRise = 1.3;
constexpr int kSearches = 12;

/// What becomes of a reference along one axis.
struct Wave {
  Samples load_mm, jerk_mm_s3;
  std::array<Samples, 2> motor_mm_s2;
};

class CornerProgram {
 public:
  CornerProgram(const Tracking& tracking, const Allowed& allowed,
                double acceleration_mm_s2, const SwingMaker::Corner& corner)
      : tracking_(tracking),
        corner_(corner),
        error_mm_(allowed.error_mm),
        motor_mm_s2_(allowed.motor_mm_s2),
        jerk_mm_s3_(allowed.jerk_mm_s3),
        acceleration_mm_s2_(acceleration_mm_s2),
        h_(tracking.options().period_s) {
    stride_ = std::max<std::size_t>(
        1, static_cast<std::size_t>(corner.half_s / kKnotsPerHalf / h_));
    half_ = stride_ * kKnotsPerHalf + tracking.kernel().half_count() + kEdge;
    hat_ = WaveOf([this](double t_s) {
      return error_mm_ * std::max(0.0, 1 - std::abs(t_s) / knot_s());
    });
  }

  std::optional<SwingShape> Solve() {
    double speed_mm_s = corner_.feed_mm_s, kept_mm_s = 0, missed_mm_s = speed_mm_s;
    std::optional<SwingShape> best;
    for (int i = 0; i < kSearches; ++i) {
      const auto found = Minimized(speed_mm_s);
      const double load_ratio = found ? (*found)[0] : 1 / kMaxFall;
      if (load_ratio <= 1) {
        best = ShapeOf(*found, speed_mm_s);
        kept_mm_s = speed_mm_s;
        if (i == 0 || load_ratio > kNearRatio) break;
      } else {
        missed_mm_s = speed_mm_s;
      }
      const double change = kRatioChange * ((1 + kNearRatio) / 2 - load_ratio);
      speed_mm_s *= std::clamp(1 + change, kMaxFall, kMaxRise);
      if (speed_mm_s <= kept_mm_s || speed_mm_s >= missed_mm_s)
        speed_mm_s = (kept_mm_s + missed_mm_s) / 2;
    }
    return best;
  }

 private:
  static constexpr std::size_t kKnots = 2 * kKnotsPerHalf - 1;
  static constexpr std::size_t kEdge = 10;  // for the derivatives

  static Eigen::Index Column(std::size_t knot, std::size_t axis) {
    return static_cast<Eigen::Index>(1 + axis * kKnots + knot);
  }
  double knot_s() const { return h_ * static_cast<double>(stride_); }

  /// The unknowns of the swing whose greatest load ratio is the least at this speed.
  std::optional<Eigen::VectorXd> Minimized(double speed_mm_s) {
    return Maximize(ProgramAt(speed_mm_s));
  }

  SwingShape ShapeOf(const Eigen::VectorXd& unknowns, double speed_mm_s) const {
    SwingShape shape;
    shape.speed_mm_s = speed_mm_s;
    shape.knot_s = knot_s();
    for (std::size_t k = 0; k < kKnots; ++k)
      shape.knots_mm.push_back(error_mm_ *
                               Vec2(unknowns[Column(k, 0)], unknowns[Column(k, 1)]));
    return shape;
  }

  template <typename F>
  Wave WaveOf(const F& reference) const {
    const std::size_t reach = half_ + tracking_.kernel().half_count();
    Samples samples;
    for (std::size_t i = 0; i <= 2 * reach; ++i)
      samples.push_back(
          reference(h_ * (static_cast<double>(i) - static_cast<double>(reach))));
    Wave wave;
    wave.load_mm = Smoothed(tracking_.kernel(), samples);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      Samples acceleration{0, 0};
      for (const double m : tracking_.axes()[axis].mechanics()) acceleration.push_back(m);
      wave.motor_mm_s2[axis] = ApplyPolynomial(acceleration, h_, wave.load_mm);
    }
    if (jerk_mm_s3_ > 0) {
      const double third[] = {0, 0, 0, 1};
      wave.jerk_mm_s3 = ApplyPolynomial(third, h_, wave.load_mm);
    }
    return wave;
  }

  /// The reference without a swing, mm along the legs: before the corner and behind it.
  using Law = std::array<Wave, 2>;

  Law LawAt(double speed_mm_s) const {
    const double a = acceleration_mm_s2_;
    const double until_s = std::max(0.0, (corner_.feed_mm_s - speed_mm_s) / a);
    Law law;
    for (const double side : {-1.0, 1.0}) {
      law[side < 0 ? 0 : 1] = WaveOf([&](double t_s) {
        const double t = std::max(0.0, side * t_s);
        const double changing_s = std::min(t, until_s);
        return side * (speed_mm_s * t + a * changing_s * (t - changing_s / 2));
      });
    }
    return law;
  }

  /// Values of a wave kind at one instant: the row's coefficients, and what is constant.
  struct Terms {
    double law = 0;
    const Samples* hat = nullptr;
  };

  void AddRow(std::size_t instant, const std::array<Terms, 2>& terms, const Vec2& along,
              double limit) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
    row[0] = -1;
    double law = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double weight = along[static_cast<Eigen::Index>(axis)] / limit;
      if (weight == 0) continue;
      law += weight * terms[axis].law;
      for (std::size_t k = 0; k < kKnots; ++k) {
        // The hat's own middle is at half_; knot k is k + 1 - kKnotsPerHalf strides on.
        const auto at = static_cast<std::ptrdiff_t>(instant + stride_ * kKnotsPerHalf) -
                        static_cast<std::ptrdiff_t>(stride_ * (k + 1));
        if (at < 0 || at > static_cast<std::ptrdiff_t>(2 * half_)) continue;
        row[Column(k, axis)] = weight * (*terms[axis].hat)[static_cast<std::size_t>(at)];
      }
    }
    rows_.push_back(std::move(row));
    limits_.push_back(-law);
  }

  template <typename Of>
  std::array<Terms, 2> TermsAt(const Law& law, std::size_t instant, const Of& of) const {
    std::array<Terms, 2> terms;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      terms[axis].hat = &of(hat_, axis);
      terms[axis].law = corner_.before[i] * of(law[0], axis)[instant] +
                        corner_.behind[i] * of(law[1], axis)[instant];
    }
    return terms;
  }

  void AddLimitsAt(const Law& law, std::size_t instant) {
    const auto load = TermsAt(
        law, instant, [](const Wave& w, std::size_t) -> auto& { return w.load_mm; });
    const auto motor = TermsAt(
        law, instant,
        [](const Wave& w, std::size_t axis) -> auto& { return w.motor_mm_s2[axis]; });
    for (const double sign : {-1.0, 1.0}) {
      for (const auto& [leg, active] : {std::pair{corner_.before, instant <= half_},
                                        std::pair{corner_.behind, instant >= half_}}) {
        if (active) AddRow(instant, load, sign * Vec2(-leg.y(), leg.x()), error_mm_);
      }
      AddRow(instant, motor, Vec2(sign, 0), motor_mm_s2_);
      AddRow(instant, motor, Vec2(0, sign), motor_mm_s2_);
    }
    if (jerk_mm_s3_ > 0) {
      const auto jerk = TermsAt(
          law, instant, [](const Wave& w, std::size_t) -> auto& { return w.jerk_mm_s3; });
      for (const double sign : {-1.0, 1.0}) {
        AddRow(instant, jerk, Vec2(sign, 0), jerk_mm_s3_);
        AddRow(instant, jerk, Vec2(0, sign), jerk_mm_s3_);
      }
    }
    // Not beyond the leg's end while it counts; far from it this needs no row.
    const std::size_t near = tracking_.kernel().half_count();
    if (instant <= half_ && instant + near >= half_)
      AddRow(instant, load, corner_.before, error_mm_);
    if (instant >= half_ && instant <= half_ + near)
      AddRow(instant, load, -corner_.behind, error_mm_);
    if (instant != half_) return;
    for (int q = 0; q < kCircleSides; ++q) {
      const double at = 2 * std::numbers::pi * q / kCircleSides;
      AddRow(instant, load, Vec2(std::cos(at), std::sin(at)),
             error_mm_ * std::cos(std::numbers::pi / kCircleSides));
    }
  }

  LinearProgram ProgramAt(double speed_mm_s) {
    rows_.clear();
    limits_.clear();
    const Law law = LawAt(speed_mm_s);
    for (std::size_t i = kEdge; i + kEdge <= 2 * half_; ++i) AddLimitsAt(law, i);
    LinearProgram program;
    const auto count = static_cast<Eigen::Index>(rows_.size());
    program.rows = Eigen::MatrixXd::Zero(count, columns());
    program.limits = Eigen::VectorXd::Zero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      program.rows.row(i) = rows_[static_cast<std::size_t>(i)].transpose();
      program.limits[i] = limits_[static_cast<std::size_t>(i)];
    }
    program.gain = Eigen::VectorXd::Zero(columns());
    program.gain[0] = -1;
    return program;
  }

  static Eigen::Index columns() { return static_cast<Eigen::Index>(1 + 2 * kKnots); }

  const Tracking& tracking_;
  const SwingMaker::Corner& corner_;
  double error_mm_, motor_mm_s2_, jerk_mm_s3_, acceleration_mm_s2_, h_;
  std::size_t stride_ = 1, half_ = 0;  ///< in periods; the corner is at instant half_
  Wave hat_;
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> limits_;
};

}  // namespace

std::optional<SwingShape> SwingMaker::Make(const Corner& corner) const {
  return CornerProgram(tracking_, allowed_, acceleration_mm_s2_, corner).Solve();
}

}  // namespace intaglio::course
