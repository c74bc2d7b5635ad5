#pragma once

// What the mirrors, the lens and the web of a scan head do, for the virtual engraver's
// own: none of it is the services' (engrave/galvo).
//
// Frame field: mm, origin in its middle. The web moves along +x, and its edge aside along
// +y; the frame material moves with it.

#include <array>
#include <cstdint>
#include <optional>
#include <random>

#include "engrave/core/geometry.h"
#include "services/virtual_engraver/head/printed_web.h"

namespace intaglio::virtual_engraver {

struct HeadPhysicsOptions {
  double field_mm = 100;
  double half_angle_rad = 0;  ///< optical, at the border; 0: a command is its place
  double lens_ratio = 0;      ///< image height f t (1 + ratio (t / half angle)^2)
  double servo_lag_s = 0.0002;
  double encoder_count_mm = 0.023, encoder_jitter_mm = 0;
  double web_mm_s = 0, web_wave_ratio = 0, web_wave_s = 1;
  double edge_wave_mm = 0, edge_wave_length_mm = 500, edge_sensor_mm = 0;
  std::optional<double> eye_mm;  ///< the photo eye before the middle of the field
  PrintOptions print;
  unsigned seed = 0;
};

/// A mirror as two equal poles: both parts turn towards what precedes them.
class MirrorServo {
 public:
  explicit MirrorServo(double lag_s) : pole_s_(lag_s / 2) {}
  /// The place after `duration_s` with this command.
  double Follow(double command, double duration_s);
  double place() const { return mirror_; }

 private:
  double pole_s_, drive_ = 0, mirror_ = 0;
};

class HeadPhysics {
 public:
  explicit HeadPhysics(const HeadPhysicsOptions& options);

  /// One tick with these outputs, of steps of field / 2^16 from 0.
  void PassTick(std::uint16_t x, std::uint16_t y, double duration_s);
  /// Where the beam meets the material, and the field.
  Vec2 PlaceOnMaterial() const;
  Vec2 PlaceInField() const;
  std::int64_t ReadEncoder();
  /// The next print mark or dirt that has passed the photo eye by now, by its place in
  /// the material along x; none: nothing has.
  struct SeenPrint {
    double place_mm = 0;
    bool printed = false;
  };
  std::optional<SeenPrint> SeePrint();
  /// At the sensor, along +y.
  double ReadEdge() const;

 private:
  double EdgeOver(double web_mm) const;

  HeadPhysicsOptions options_;
  std::array<MirrorServo, 2> mirrors_;
  double focal_mm_ = 0;
  double time_s_ = 0, web_mm_ = 0;
  PrintedWeb print_;
  std::mt19937_64 random_;
};

}  // namespace intaglio::virtual_engraver
