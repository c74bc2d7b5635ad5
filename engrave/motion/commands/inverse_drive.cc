#include "engrave/motion/commands/inverse_drive.h"

#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace intaglio::motion {
namespace {

/// At `t_s` of the course, with its derivatives.
drive::Cubic CubicAt(const drive::Cubic& c, double t_s) {
  return {c.At(t_s), c.VelocityAt(t_s), c.acceleration_u_s2 + t_s * c.jerk_u_s3,
          c.jerk_u_s3};
}

}  // namespace

InverseDrive::InverseDrive(const drive::Drive* drive, double start) : command_(start) {
  if (drive == nullptr) return;
  const drive::Transfer transfer = drive->transfer();
  series_ = drive::SeriesOf(transfer.denominator, transfer.numerator);
  const std::size_t poles = drive::OrderOf(transfer.denominator);
  const std::size_t zeros = drive::OrderOf(transfer.numerator);
  if (zeros == 0 || zeros > 2 || poles < zeros + 1) return;
  if (zeros == 1 && poles > 2) return;
  zeros_ = static_cast<int>(zeros);
  b1_s_ = transfer.numerator[1];
  b2_s2_ = transfer.numerator[2];
  if (zeros == 2) kick_s_ = transfer.denominator[3] / b2_s2_;
}

InverseDrive::Command InverseDrive::WithoutTransients(const drive::Cubic& course) const {
  return {course.position_u + series_[1] * course.velocity_u_s +
              series_[2] * course.acceleration_u_s2 + series_[3] * course.jerk_u_s3,
          course.velocity_u_s + series_[1] * course.acceleration_u_s2 +
              series_[2] * course.jerk_u_s3};
}

InverseDrive::Command InverseDrive::AtBegin(const drive::Cubic& course) const {
  if (zeros_ == 2) {
    return {command_,
            command_per_s_ + kick_s_ * (course.acceleration_u_s2 - last_acceleration_)};
  }
  const Command settled = WithoutTransients(course);
  return {command_, settled.velocity - (command_ - settled.position) / b1_s_};
}

InverseDrive::Command InverseDrive::Follow(const drive::Cubic& course,
                                           double duration_s) {
  const Command begin = AtBegin(course), settled = WithoutTransients(course);
  const drive::Cubic end = CubicAt(course, duration_s);
  Command command = WithoutTransients(end);
  const double rest = begin.position - settled.position;
  const double rest_per_s = begin.velocity - settled.velocity;
  if (zeros_ == 1) {
    const double left = std::exp(-duration_s / b1_s_);
    command.position += left * rest;
    command.velocity += left * rest_per_s;
  } else {
    // In the time sqrt b2, so that both rows are of one size.
    const double unit_s = std::sqrt(b2_s2_);
    Eigen::Matrix2d matrix;
    matrix << 0, 1, -1, -b1_s_ / unit_s;
    matrix = ((duration_s / unit_s) * matrix).exp().eval();
    command.position += matrix(0, 0) * rest + matrix(0, 1) * unit_s * rest_per_s;
    command.velocity += matrix(1, 0) / unit_s * rest + matrix(1, 1) * rest_per_s;
  }
  command_ = command.position;
  command_per_s_ = command.velocity;
  last_acceleration_ = end.acceleration_u_s2;
  return command;
}

}  // namespace intaglio::motion
