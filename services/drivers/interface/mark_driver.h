#pragma once

// What a controller that makes marks (engrave/mark) has to be able to do for the marker:
// a scan head's board, or the controller of a mill or a laser that follows contours. It
// moves and switches the beam by one line, and reports what has become of each mark.
//
// Marks are numbered by their place in the order of the job. A run is a row of marks that
// are appended one behind the other; the controller makes them in that order.
//
// Guarantees of every driver together with its controller; each is checked for all that
// MarkDriverKinds lists (tests/services/drivers/marks/mark_conformance.cc):
//   K1  Nothing blocks. What cannot be taken now is refused with an error, and nothing of
//       it is done.
//   K2  The beam is on, or the tool turns, only within marks of a run of this session,
//       and only while it is permitted: Permit(true) is repeated by the host; without it
//       for 250 ms the controller (not the host) ends the beam. A machine that can_hold
//       rests then as K11 says, and ends tool and run after kMaxHold.
//   K3  A mark that was appended once is made at most once, whatever is repeated on the
//       line. kBegun comes before anything of it can be made, kDone after all of it was
//       made, each once and in order. kBroken ends a mark that was begun and not ended.
//       A mark that the controller dropped before it was in hand ends as kNotBegun, even
//       behind its kBegun, and one whose repeat has no print mark as kNoPrintMark.
//   K4  Stop, a withdrawn permission, an interlock, a fault and a lost line end the beam
//       and drop what was appended. What of it was not begun is not made, and
//       settled() is true once that is known.
//   K5  Pause ends the run at the end of the mark in hand.
//   K6  After a lost line or a killed host RequestPast tells what became of the newest
//       kRememberedMarks marks of the power-up, whichever session appended them, as far
//       as the controller remembers (remembers_marks); without a memory they are
//       uncertain. Marks of a run are appended in rising order: behind one that it knows,
//       one that it does not know (kUncertain) never came.
//   K7  Key, door and stop button end the beam, and openings() counts each letting go.
//   K8  A controller with another serial number than the profile's is refused.
//   K9  What the controller reports of itself is never a lost line alone: a reset, an
//       emergency stop, a hold, a limit, an alarm and an error end the run and are
//       counted among state().openings, or are another power_up, as a power cycle is; of
//       a controller that does not tell a cable that was pulled from a power cycle, each
//       lost line is one. No
//       beam lights, and nothing moves or is unlocked, before Reset and a new run.
//   K10 Where the controller may not know where its tool is, place_lost says so, and no
//       run begins, until a person has homed it or has set its zero.
//   K11 A machine that can_hold rests by Hold behind what it was sent, at most kHoldTime
//       of motion: its tool goes on turning, and the mark in hand neither ends nor
//       breaks. The next Permit(true) goes on with it, and all else of K2 to K10 holds
//       meanwhile. Every other machine refuses Hold, and nothing of it is done.
//   K12 A guide laser is dark, whatever is permitted, made, lost or at rest, but for
//       hand()->DrawOutline: on the way of the outline, from its first corner on, until
//       it is held, a fault, an opening of the chain or a lost line ends it. Until the
//       mirrors rest behind it the beam stays off, whatever is permitted, and no run
//       begins; in a run, or with a fault, no outline begins. It does not go on by
//       itself.
// Not thread-safe.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "services/drivers/interface/hand_motion.h"
#include "services/drivers/interface/print_eye.h"

namespace intaglio::drivers {

inline constexpr std::size_t kRememberedMarks = 1024;
/// Of motion that was sent when a machine is held.
inline constexpr std::chrono::milliseconds kHoldTime{300};
/// A tool that turns and rests in the work is ended behind this.
inline constexpr std::chrono::milliseconds kMaxHold{2000};

/// In the order in which a mark goes through them.
enum class MarkFate : std::uint8_t {
  kBegun,      ///< something of it may have been made
  kDone,       ///< all of it was made
  kBroken,     ///< begun, and ended before its end
  kNotBegun,   ///< dropped before its beginning: nothing of it was made
  kUncertain,  ///< the controller does not know it (answers of RequestPast only)
  /// Its repeat has no print mark: nothing of it was made, and nothing may be.
  kNoPrintMark,
};

struct MarkEvent {
  std::uint32_t run = 0;
  std::uint32_t mark = 0;
  MarkFate fate = MarkFate::kBegun;
};

/// A mark on its way to the controller.
struct NumberedMark {
  std::uint32_t number = 0;  ///< place in the order of the job
  mark::Mark mark;
};

/// What the controller is and says; of the newest status while the line is up.
struct MarkDeviceState {
  bool link_up = false;       ///< connected, identified, a status has come
  std::string message;        ///< why it is not, or what a person should know; else empty
  std::string refusal;        ///< why the controller that answers is refused; else empty
  bool taken_over = false;    ///< another host has it, for good
  std::uint64_t session = 0;  ///< grows with each, whenever what was sent may be lost
  /// Another text is another power-up or reset of the controller, or a host that did not
  /// watch it before; never empty while the line is up.
  std::string power_up;
  bool remembers_marks = false;
  /// It can rest within a mark without harm to the piece: a spindle, which goes on
  /// turning, and a virtual machine in lockstep, whose time waits. A beam burns a hole.
  bool can_hold = false;

  bool key_on = false, door_closed = false, stop_released = false;
  /// While it is permitted, also before a run. Of a mill: the spindle may turn.
  bool shutter_open = false;
  bool safe_state = false;  ///< the controller ended the beam by itself
  /// Lettings go of key, door and stop button, and stops of the controller's own: a hold,
  /// an alarm, a limit, a line that it refused.
  std::uint32_t openings = 0;
  /// Why the controller may not know where its tool is, and what to do; no run begins
  /// before a person has homed it or set its zero. Empty: it knows.
  std::string place_lost = {};
  /// Zero of the piece in the axes of the controller, mm; none: it keeps none.
  std::optional<Vec3> work_offset_mm = {};
  /// Grows when they may count from another place than before, so that a zero of before
  /// cannot be compared: the place was lost, and no switches find it again.
  std::uint32_t axes_number = 0;

  /// Greatest run that this power-up has begun, of any job and host; 0: none, or the
  /// controller keeps no runs.
  std::uint32_t newest_run = 0;

  bool at_rest = true;              ///< no run, nothing moves
  bool settled = true;              ///< nothing that was appended can still be made
  std::string fault;                ///< of the last run, with the remedy; empty: none
  Vec3 position_mm = Vec3::Zero();  ///< of the focus or the tool, frame of the piece
  double web_mm_s = 0;              ///< speed of the web by its encoder
  /// What the photo eye has seen in the run that uses it, for a person; else empty.
  std::string print_text = {};
  std::uint64_t number = 0;  ///< statuses of this session; grows with each
};

class MarkDriver {
 public:
  virtual ~MarkDriver() = default;
  /// Motion by hand, and the zero of a person; null: this family has none. While it moves
  /// the state is not settled, and no run begins. The same object lives as long as this.
  virtual HandMotion* hand() { return nullptr; }

  /// Moves the line's bytes and takes what came.
  virtual void Poll() = 0;
  /// For poll(2); -1 when there is none.
  virtual int fd() const = 0;
  virtual const MarkDeviceState& state() const = 0;
  /// What has become of marks since the last call, in order.
  virtual std::vector<MarkEvent> TakeEvents() = 0;

  /// Repeated by the host at least every 50 ms while it may mark; false ends the beam.
  virtual Status Permit(bool permitted) = 0;
  /// The permission of the host itself is late: the run rests until it comes. Refused
  /// without a run, and by a machine that cannot.
  virtual Status Hold();
  /// The repeats of the runs that begin from now on begin at print marks; none: by the
  /// encoder alone. kUnsupported: this machine has no photo eye.
  virtual Status UseEye(const std::optional<PrintEye>& eye);
  /// A new run of the marks of these pens, `run` greater than all before. Refused while
  /// !settled, or with a fault.
  virtual Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) = 0;
  /// Marks that may be appended now.
  virtual std::size_t Room() const = 0;
  virtual Status Append(const NumberedMark& mark) = 0;
  /// Nothing more is appended to this run: it ends behind its last mark, at rest.
  virtual Status Finish() = 0;
  virtual Status Pause() = 0;
  /// At once.
  virtual Status Stop() = 0;
  /// After a fault or a safe state.
  virtual Status Reset() = 0;
  /// Marks `first` .. `first + count - 1` of `run`; answered by TakeEvents, each once.
  virtual Status RequestPast(std::uint32_t run, std::uint32_t first,
                             std::uint32_t count) = 0;
};

}  // namespace intaglio::drivers
