#include "engrave/motion/commands/inverse_drive.h"

#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace intaglio::motion {
namespace {

/// At `t_s` of the course, with its derivatives.
CubicCourse At(const CubicCourse& c, double t_s) {
  return {c.position_mm + t_s * (c.velocity_mm_s + t_s * (c.acceleration_mm_s2 / 2 +
                                                          t_s * c.jerk_mm_s3 / 6)),
          c.velocity_mm_s + t_s * (c.acceleration_mm_s2 + t_s * c.jerk_mm_s3 / 2),
          c.acceleration_mm_s2 + t_s * c.jerk_mm_s3, c.jerk_mm_s3};
}

}  // namespace

InverseDrive::InverseDrive(const drive::Drive* drive, const Vec3& start_mm)
    : command_mm_(start_mm) {
  if (drive == nullptr) return;
  const drive::Transfer transfer = drive->transfer();
  series_ = drive::SeriesOf(transfer.denominator, transfer.numerator);
  const std::size_t poles = drive::OrderOf(transfer.denominator);
  const std::size_t zeros = drive::OrderOf(transfer.numerator);
  if (zeros == 0 || zeros > 2 || zeros + 1 != poles) return;
  zeros_ = static_cast<int>(zeros);
  b1_s_ = transfer.numerator[1];
  b2_s2_ = transfer.numerator[2];
  if (zeros == 2) kick_s_ = transfer.denominator[3] / b2_s2_;
}

InverseDrive::Command InverseDrive::WithoutTransients(const CubicCourse& course) const {
  return {course.position_mm + series_[1] * course.velocity_mm_s +
              series_[2] * course.acceleration_mm_s2 + series_[3] * course.jerk_mm_s3,
          course.velocity_mm_s + series_[1] * course.acceleration_mm_s2 +
              series_[2] * course.jerk_mm_s3};
}

InverseDrive::Command InverseDrive::AtBegin(const CubicCourse& course) const {
  if (zeros_ == 2) {
    return {command_mm_, command_mm_s_ + kick_s_ * (course.acceleration_mm_s2 -
                                                    last_acceleration_mm_s2_)};
  }
  const Command settled = WithoutTransients(course);
  return {command_mm_,
          settled.velocity_mm_s - (command_mm_ - settled.position_mm) / b1_s_};
}

InverseDrive::Command InverseDrive::Follow(const CubicCourse& course, double duration_s) {
  const Command begin = AtBegin(course), settled = WithoutTransients(course);
  const CubicCourse end = At(course, duration_s);
  Command command = WithoutTransients(end);
  const Vec3 rest_mm = begin.position_mm - settled.position_mm;
  const Vec3 rest_mm_s = begin.velocity_mm_s - settled.velocity_mm_s;
  if (zeros_ == 1) {
    const double left = std::exp(-duration_s / b1_s_);
    command.position_mm += left * rest_mm;
    command.velocity_mm_s += left * rest_mm_s;
  } else {
    // In the time sqrt b2, so that both rows are of one size.
    const double unit_s = std::sqrt(b2_s2_);
    Eigen::Matrix2d matrix;
    matrix << 0, 1, -1, -b1_s_ / unit_s;
    matrix = ((duration_s / unit_s) * matrix).exp().eval();
    command.position_mm += matrix(0, 0) * rest_mm + matrix(0, 1) * unit_s * rest_mm_s;
    command.velocity_mm_s += matrix(1, 0) / unit_s * rest_mm + matrix(1, 1) * rest_mm_s;
  }
  command_mm_ = command.position_mm;
  command_mm_s_ = command.velocity_mm_s;
  last_acceleration_mm_s2_ = end.acceleration_mm_s2;
  return command;
}

}  // namespace intaglio::motion
