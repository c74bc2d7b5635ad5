#include "tests/engrave/galvo/virtual_head.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

namespace intaglio::galvo {
namespace {

constexpr double kTickSeconds = 1e-5;
constexpr int kPartsOfTick = 8;

}  // namespace

double TwoPoleServo::Advance(double command, double duration_s) {
  if (pole_s_ == 0) return first_ = second_ = command;
  // x1' = (c - x1) / T, x2' = (x1 - x2) / T, solved for a constant c.
  const double t = duration_s / pole_s_, decay = std::exp(-t);
  const double d1 = first_ - command, d2 = second_ - command;
  first_ = command + d1 * decay;
  second_ = command + (d2 + d1 * t) * decay;
  return second_;
}

std::int64_t EncoderCount(double place_mm, double quantum_mm) {
  return static_cast<std::int64_t>(std::floor(place_mm / quantum_mm + 0.37));
}

VirtualHead::VirtualHead(const WrongField* field, double width_mm, double lag_s)
    : field_(field),
      width_mm_(width_mm),
      lag_s_(lag_s),
      servos_{TwoPoleServo(lag_s, 0), TwoPoleServo(lag_s, 0)} {}

Vec2 VirtualHead::Spot() const {
  const Vec2 command_mm(servos_[0].place(), servos_[1].place());
  return field_ == nullptr ? command_mm : field_->Arrive(command_mm);
}

void VirtualHead::Output(std::uint16_t x, std::uint16_t y, bool laser, double web_mm,
                         double web_mm_s) {
  const double lsb_mm = width_mm_ / 65536;
  const Vec2 command_mm(lsb_mm * (x - 32768.0), lsb_mm * (y - 32768.0));
  if (!begun_) {
    servos_ = {TwoPoleServo(lag_s_, command_mm.x()),
               TwoPoleServo(lag_s_, command_mm.y())};
    begun_ = true;
  }
  for (int part = 0; part <= kPartsOfTick; ++part) {
    const double since_s = kTickSeconds * part / kPartsOfTick;
    if (part > 0) {
      servos_[0].Advance(command_mm.x(), kTickSeconds / kPartsOfTick);
      servos_[1].Advance(command_mm.y(), kTickSeconds / kPartsOfTick);
    }
    if (laser && lag_s_ > 0)
      burnt_.push_back(Spot() - Vec2(web_mm + web_mm_s * since_s, 0));
  }
  // Without a lag the beam jumps at each tick: where it is then is what it burns.
  if (laser && lag_s_ == 0)
    burnt_.push_back(Spot() - Vec2(web_mm + web_mm_s * kTickSeconds / 2, 0));
}

std::vector<Vec2> VirtualHead::TakeBurnt() { return std::exchange(burnt_, {}); }

FittedCircle FitCircle(const std::vector<Vec2>& places_mm) {
  // About the first place: squares of metres would cost micrometres.
  const Vec2 origin_mm = places_mm.front();
  Eigen::MatrixXd left(static_cast<Eigen::Index>(places_mm.size()), 3);
  Eigen::VectorXd right(left.rows());
  for (Eigen::Index i = 0; i < left.rows(); ++i) {
    const Vec2 p = places_mm[static_cast<std::size_t>(i)] - origin_mm;
    left.row(i) << 2 * p.x(), 2 * p.y(), 1;
    right[i] = p.squaredNorm();
  }
  const Eigen::Vector3d s =
      (left.transpose() * left).ldlt().solve(left.transpose() * right);
  FittedCircle circle{s.head<2>() + origin_mm,
                      std::sqrt(s[2] + s.head<2>().squaredNorm()), 0};
  for (const Vec2& p : places_mm)
    circle.shape_mm = std::max(
        circle.shape_mm, std::abs((p - circle.centre_mm).norm() - circle.radius_mm));
  return circle;
}

}  // namespace intaglio::galvo
