#pragma once

// A scan head over a moving web, of the tests' own: outputs of 16 bits move two servos of
// two equal poles each, whose beam is traced through mirrors and lens; what the laser
// burns is kept where it is on the material. It shares no code with engrave/galvo.
//
// It is kept beside the head of services/virtual_engraver, which is part of the product:
// the tests of engrave/ do without services, and head_physics_test compares the two, so
// that a mistake in the optics of one does not go unseen.

#include <array>
#include <cstdint>
#include <vector>

#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::galvo {

/// Two equal poles whose delays add up to the lag; the command is held between ticks.
class TwoPoleServo {
 public:
  TwoPoleServo(double lag_s, double at) : pole_s_(lag_s / 2), first_(at), second_(at) {}
  /// After `duration_s` with this command.
  double Advance(double command, double duration_s);
  double place() const { return second_; }

 private:
  double pole_s_, first_, second_;
};

struct WebMotion {
  double speed_mm_s = 0;                 ///< along +x
  double edge_mm = 0, edge_wave_mm = 0;  ///< amplitude and length of a wave of the edge
  double At(double time_s) const { return speed_mm_s * time_s; }
};

/// Counts of an encoder with this quantum.
std::int64_t EncoderCount(double place_mm, double quantum_mm);

class VirtualHead {
 public:
  /// `field` is null: an ideal field, the command is the place.
  VirtualHead(const WrongField* field, double width_mm, double lag_s);

  /// One tick of 10 us of these outputs; `web_mm`: how far the web has moved at its
  /// begin, `web_mm_s` its speed. Burnt places are added to burnt().
  void Output(std::uint16_t x, std::uint16_t y, bool laser, double web_mm,
              double web_mm_s);

  /// Places on the material, mm, eight a tick and the last of the laser.
  const std::vector<Vec2>& burnt() const { return burnt_; }
  std::vector<Vec2> TakeBurnt();

 private:
  Vec2 Spot() const;

  const WrongField* field_;
  double width_mm_, lag_s_;
  bool begun_ = false;
  std::array<TwoPoleServo, 2> servos_;
  std::vector<Vec2> burnt_;
};

/// Least squares circle of places (Kasa).
struct FittedCircle {
  Vec2 centre_mm = Vec2::Zero();
  double radius_mm = 0;
  double shape_mm = 0;  ///< largest distance of a place from it
};
FittedCircle FitCircle(const std::vector<Vec2>& places_mm);

}  // namespace intaglio::galvo
