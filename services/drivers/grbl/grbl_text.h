#pragma once

// The text of the grbl family: answers of a controller as values, and its errors and
// alarms as sentences. An answer is a line of ASCII that ends in CR LF; what is not known
// is kept as GrblOther and means nothing.
//
// Source: gnea/grbl wiki "Grbl v1.1 Interface"; grblHAL core report.c for the options.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::drivers {

/// The byte that resets the controller, at any time: dark with the last step.
inline constexpr char kGrblReset = 0x18;

enum class GrblState : std::uint8_t {
  kIdle,
  kRun,
  kHold,  ///< Hold:0 at rest, Hold:1 braking
  kJog,
  kDoor,  ///< Door:0 closed again, Door:1 open at rest, others braking or resuming
  kAlarm,
  kHome,
  kOther,  ///< Check, Sleep, Tool
};

struct GrblOk {};
struct GrblError {
  int code = 0;
};
struct GrblAlarm {
  int code = 0;
};
/// After a reset and after power-up.
struct GrblBanner {};
/// The answer to '?'.
struct GrblStatus {
  GrblState state = GrblState::kOther;
  int substate = -1;
  std::optional<Vec3> work_mm, machine_mm, work_offset_mm;
  int free_blocks = -1, free_bytes = -1;  ///< -1: not reported
  std::int64_t line = 0;                  ///< 0: not reported
  double feed_mm_min = 0;
  std::string pins;  ///< of Pn:, e.g. "D" for the door

  /// Nothing moves, and nothing will without a command.
  bool at_rest() const {
    return state == GrblState::kIdle || state == GrblState::kAlarm ||
           (state == GrblState::kHold && substate == 0) ||
           (state == GrblState::kDoor && (substate == 0 || substate == 1));
  }
};
/// [VER:1.1h.20190830:G-03]: the last part is the owner's text, here the serial number.
struct GrblVersion {
  std::string version, serial_number;
};
/// [OPT:VN+,15,128]
struct GrblBuild {
  std::string letters;
  int planner_blocks = 0, receive_bytes = 0;  ///< 0: not reported
};
/// $110=500.000
struct GrblSetting {
  int number = 0;
  double value = 0;
};
/// [GC:G1 G54 G17 G21 G90 G94 M5 M9 T0 F600 S0], the answer to $G.
struct GrblModes {
  /// G0 without a feed, as a reset and a power-up leave them: this host's set-up ends
  /// with G1, and every G1 of it has a feed.
  bool as_after_reset = false;
};
struct GrblOther {};

using GrblAnswer =
    std::variant<GrblOther, GrblOk, GrblError, GrblAlarm, GrblBanner, GrblStatus,
                 GrblVersion, GrblBuild, GrblSetting, GrblModes>;

/// Of one line, without its end. Never fails.
GrblAnswer ParseGrblAnswer(std::string_view line);

/// What a controller means by error:N and ALARM:N, for people.
std::string TextOfGrblError(int code);
std::string TextOfGrblAlarm(int code);

/// Lines out of bytes. A line that is longer than any answer is dropped whole.
class GrblAnswerReader {
 public:
  void Feed(std::span<const std::byte> bytes, std::vector<std::string>& lines);
  void Clear() { line_.clear(), overlong_ = false; }

 private:
  static constexpr std::size_t kMaxLine = 512;
  std::string line_;
  bool overlong_ = false;
};

/// G10L20P1: the place of the tool has these coordinates in G54, in the axes of `sets`.
std::string ZeroLine(const Vec3& here_mm, const std::array<bool, 3>& sets);

/// A sentence about a line of the set-up that was refused with error:CODE.
std::string WhyGrblIsNotSetUp(int code);

/// A sentence about GrblLine::place_is_lost(), with what a person does about it.
std::string WhyGrblPlaceIsLost(const std::string& remedy);

}  // namespace intaglio::drivers
