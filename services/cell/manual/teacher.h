#pragma once

// What is taught at one machine, for the desk that takes the orders of people
// (manual_desk.h).

#include <array>
#include <cstdint>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "idl/teach.h"

namespace intaglio::cell {

/// The axes of a machine as a person sees them, with what is taught at it.
struct TaughtAxes {
  std::array<std::string, 3> names = {"x", "y", "z"};
  std::uint8_t rotary = 0;  ///< bit 0..2: axes in rad, else mm
  Box3 limits;              ///< of motion by hand
  std::string profile;      ///< file in which it is saved
  std::uint32_t taught_number = 0;
};

class Teacher {
 public:
  virtual ~Teacher() = default;
  virtual TaughtAxes axes() const = 0;
  /// Channels whose lamp and shutters are switched by hand; 0: none.
  virtual std::uint32_t channel_count() const = 0;
  /// The zero is kept by the controller (HandMotion::SetZero), and not saved here.
  virtual bool zero_is_in_controller() const { return false; }
  /// The axes where the focus is at the zero that `command` names, from `position`.
  /// Errors are for the person.
  virtual Result<Vec3> AxesAtZero(const intaglio_ManualCommand& command,
                                  const Vec3& position) const = 0;
  /// Saves what `command` teaches with the axes at `position`; a sentence about it.
  /// Errors are for the person.
  virtual Result<std::string> Save(const intaglio_ManualCommand& command,
                                   const Vec3& position) = 0;
};

}  // namespace intaglio::cell
