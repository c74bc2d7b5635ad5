#include "services/virtual_engraver/head/head_physics.h"

#include <cmath>
#include <numbers>

namespace intaglio::virtual_engraver {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// A ray reflected at a mirror whose normal is `normal`, of length 1.
Vec3 AtMirror(const Vec3& ray, const Vec3& normal) {
  return ray - 2 * ray.dot(normal) * normal;
}

Vec3 AboutZ(const Vec3& v, double rad) {
  const double c = std::cos(rad), s = std::sin(rad);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

Vec3 AboutY(const Vec3& v, double rad) {
  const double c = std::cos(rad), s = std::sin(rad);
  return {c * v.x() + s * v.z(), v.y(), c * v.z() - s * v.x()};
}

/// Behind both mirrors, of a laser along +y: the first turns about z, the second about y.
/// They turn by half of the optical angles.
Vec3 BehindMirrors(double x_rad, double y_rad) {
  const double half = std::numbers::sqrt2 / 2;
  const Vec3 first = AboutZ(Vec3(half, -half, 0), y_rad / 2);
  const Vec3 second = AboutY(Vec3(-half, 0, half), x_rad / 2);
  return AtMirror(AtMirror(Vec3(0, 1, 0), first), second);
}

}  // namespace

// x1' = (c - x1) / T, x2' = (x1 - x2) / T, for a constant c.
double MirrorServo::Follow(double command, double duration_s) {
  if (pole_s_ == 0) return drive_ = mirror_ = command;
  const double t = duration_s / pole_s_, decay = std::exp(-t);
  const double drive_off = drive_ - command, mirror_off = mirror_ - command;
  drive_ = command + drive_off * decay;
  mirror_ = command + (mirror_off + drive_off * t) * decay;
  return mirror_;
}

HeadPhysics::HeadPhysics(const HeadPhysicsOptions& options)
    : options_(options),
      mirrors_{MirrorServo(options.servo_lag_s), MirrorServo(options.servo_lag_s)},
      print_(options.print),
      random_(options.seed) {
  if (options.half_angle_rad > 0)
    focal_mm_ = options.field_mm / 2 / options.half_angle_rad;
}

void HeadPhysics::PassTick(std::uint16_t x, std::uint16_t y, double duration_s) {
  const double step_mm = options_.field_mm / 65536;
  mirrors_[0].Follow(step_mm * (x - 32768.0), duration_s);
  mirrors_[1].Follow(step_mm * (y - 32768.0), duration_s);
  time_s_ += duration_s;
  // The integral of v (1 + r sin(2 pi t / T)).
  const double wave_s = options_.web_wave_s / kTurn;
  web_mm_ = options_.web_mm_s * (time_s_ + options_.web_wave_ratio * wave_s *
                                               (1 - std::cos(time_s_ / wave_s)));
}

Vec2 HeadPhysics::PlaceInField() const {
  const Vec2 command_mm(mirrors_[0].place(), mirrors_[1].place());
  if (focal_mm_ == 0) return command_mm;
  const Vec3 ray = BehindMirrors(command_mm.x() / focal_mm_, command_mm.y() / focal_mm_);
  const double aside = ray.head<2>().norm();
  if (aside == 0) return Vec2::Zero();
  const double angle = std::atan2(aside, ray.z());
  const double share = angle / options_.half_angle_rad;
  const double height_mm = focal_mm_ * angle * (1 + options_.lens_ratio * share * share);
  return height_mm / aside * ray.head<2>();
}

double HeadPhysics::EdgeOver(double web_mm) const {
  return options_.edge_wave_mm * std::sin(kTurn * web_mm / options_.edge_wave_length_mm);
}

// The place of the web that is below the middle of the field passed the sensor when the
// web had come less far by the sensor's distance.
Vec2 HeadPhysics::PlaceOnMaterial() const {
  return PlaceInField() - Vec2(web_mm_, EdgeOver(web_mm_ - options_.edge_sensor_mm));
}

std::optional<HeadPhysics::SeenPrint> HeadPhysics::SeePrint() {
  if (!options_.eye_mm) return std::nullopt;
  const auto passed = print_.Next(web_mm_);
  if (!passed) return std::nullopt;
  return SeenPrint{-*options_.eye_mm - passed->place_mm, passed->printed};
}

double HeadPhysics::ReadEdge() const { return EdgeOver(web_mm_); }

std::int64_t HeadPhysics::ReadEncoder() {
  std::uniform_real_distribution<double> off(-options_.encoder_jitter_mm,
                                             options_.encoder_jitter_mm);
  const double read_mm = web_mm_ + (options_.encoder_jitter_mm > 0 ? off(random_) : 0.0);
  return static_cast<std::int64_t>(std::floor(read_mm / options_.encoder_count_mm));
}

}  // namespace intaglio::virtual_engraver
