// The lines of a virtual grbl: G-code, jogs and the system's '$' commands.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "services/virtual_engraver/mill/virtual_grbl.h"

namespace intaglio::grbl {
namespace {

constexpr int kExpectedLetter = 1, kBadNumber = 2, kUnknownSystem = 3, kNotIdle = 8,
              kLocked = 9, kTooLong = 11, kTravelExceeded = 15, kUnsupported = 20,
              kNoFeed = 22, kBadArc = 33, kStopIsPressed = 50;
constexpr std::size_t kMaxLineBytes = 79;
// Any dwell lasts at least this long.
constexpr double kMinDwell_us = 50000;

}  // namespace

struct VirtualGrbl::GcodeLine {
  std::vector<int> g, m;  // times 10
  std::optional<double> x[3], i, j, f, s, p;
  std::int64_t n = 0;
  int l = -1;

  /// 0, or grbl's error.
  int Read(const std::string& line) {
    std::size_t at = 0;
    while (at < line.size()) {
      const char letter = line[at++];
      if (letter == ' ') continue;
      if (std::isupper(static_cast<unsigned char>(letter)) == 0) return kExpectedLetter;
      std::size_t end = at;
      while (end < line.size() && (std::isdigit(static_cast<unsigned char>(line[end])) ||
                                   line[end] == '.' || line[end] == '-')) {
        ++end;
      }
      double value = 0;
      const auto [last, error] =
          std::from_chars(line.data() + at, line.data() + end, value);
      if (error != std::errc{} || last != line.data() + end) return kBadNumber;
      at = end;
      if (const int bad = Receive(letter, value)) return bad;
    }
    return 0;
  }
  int Receive(char letter, double value) {
    if (letter == 'G')
      g.push_back(static_cast<int>(std::lround(value * 10)));
    else if (letter == 'M')
      m.push_back(static_cast<int>(std::lround(value * 10)));
    else if (letter >= 'X' && letter <= 'Z')
      x[letter - 'X'] = value;
    else if (letter == 'I')
      i = value;
    else if (letter == 'J')
      j = value;
    else if (letter == 'F')
      f = value;
    else if (letter == 'S')
      s = value;
    else if (letter == 'P')
      p = value;
    else if (letter == 'N')
      n = static_cast<std::int64_t>(value);
    else if (letter == 'L')
      l = static_cast<int>(value);
    else
      return kUnsupported;
    return 0;
  }
  bool has(int code) const { return std::find(g.begin(), g.end(), code) != g.end(); }
  bool is_arc() const { return has(20) || has(30); }
  bool moves() const { return x[0] || x[1] || x[2]; }
};

void VirtualGrbl::Execute(const std::string& line) {
  ++lines_taken_;
  if (line.size() > kMaxLineBytes) return Answer(kTooLong);
  if (line.empty()) return Answer(0);
  if (line.rfind("$J=", 0) == 0) {
    if (state_ != State::kIdle && state_ != State::kJog) {
      return Answer(state_ == State::kAlarm ? kLocked : kNotIdle);
    }
    return ExecuteGcode(line.substr(3), true);
  }
  if (line[0] == '$') return ExecuteSystem(line);
  if (state_ == State::kAlarm || state_ == State::kJog) return Answer(kLocked);
  ExecuteGcode(line, false);
}

void VirtualGrbl::PrintSettings() {
  Send(fmt::format(
      "$10=2\r\n$12={:.3f}\r\n$20={:d}\r\n$22={:d}\r\n$30={:g}\r\n$31=0\r\n$32={:d}\r\n",
      options_.arc_tolerance_mm, options_.soft_limits, options_.homing,
      options_.max_power, options_.laser_mode));
  const Vec3 travel = options_.travel_max_mm - options_.travel_min_mm;
  for (int i = 0; i < 3; ++i) {
    Send(
        fmt::format("$10{0}={1:.3f}\r\n$11{0}={2:.3f}\r\n$12{0}={3:.3f}\r\n"
                    "$13{0}={4:.3f}\r\n",
                    i, options_.motion.steps_per_mm, options_.motion.max_speed_mm_s * 60,
                    options_.motion.acceleration_mm_s2, travel[i]));
  }
}

void VirtualGrbl::ExecuteSystem(const std::string& line) {
  if (options_.hal && emergency_stop_ && (line == "$X" || line == "$H"))
    return Answer(kStopIsPressed);
  if (line == "$X") {
    if (state_ == State::kAlarm) Send("[MSG:Caution: Unlocked]\r\n");
    locked_ = false;
    return Answer(0);
  }
  if (line == "$G") {
    const int spindle = spindle_ == Spindle::kOff       ? 5
                        : spindle_ == Spindle::kDynamic ? 4
                                                        : 3;
    Send(fmt::format("[GC:G{:d} G54 G17 G21 G{} G94 M{} M9 T0 F{:.0f} S{:.0f}]\r\n",
                     !rapid_, absolute_ ? 90 : 91, spindle, feed_mm_min_, power_));
    return Answer(0);
  }
  if (state_ != State::kIdle && state_ != State::kAlarm) return Answer(kNotIdle);
  if (line == "$I") {
    Send(fmt::format("[VER:1.1{}:{}]\r\n[OPT:VN+,{},{}]\r\n",
                     options_.hal ? "f.20260801" : "h.20190830", options_.serial_number,
                     options_.motion.planner_blocks, options_.receive_bytes));
  } else if (line == "$$") {
    PrintSettings();
  } else if (line == "$H") {
    if (!options_.homing) return Answer(5);
    return BeginHome();
  } else if (line == "$32=0" || line == "$32=1") {
    options_.laser_mode = line.back() == '1';
  } else {
    return Answer(kUnknownSystem);
  }
  Answer(0);
}

Beam VirtualGrbl::BeamOf(bool rapid) const {
  if (spindle_ == Spindle::kOff || power_ <= 0) return Beam::kDark;
  if (!options_.laser_mode) return Beam::kConstant;
  if (rapid) return Beam::kDark;
  if (spindle_ == Spindle::kConstant) return Beam::kConstant;
  return Beam::kDynamic;
}

void VirtualGrbl::ExecuteGcode(const std::string& line, bool jog) {
  GcodeLine words;
  if (const int bad = words.Read(line)) return Answer(bad);
  if (jog) {
    if (!words.f) return Answer(kNoFeed);
    if (!words.moves()) return Answer(26);
    if (const int bad = QueueMotion(words, true)) Answer(bad);
    return;
  }
  for (const int code : words.g) {
    for (const int known : {0, 10, 20, 30, 40, 100, 210, 900, 910, 940, 540, 170}) {
      if (code == known) goto next;
    }
    return Answer(kUnsupported);
  next:;
  }
  if (words.f) feed_mm_min_ = *words.f;
  if (words.s) power_ = *words.s;
  if (words.s && *words.s > 0) powers_.insert(*words.s);
  if (words.has(900)) absolute_ = true;
  if (words.has(910)) absolute_ = false;
  if (words.has(0)) rapid_ = true;
  if (words.has(10) || words.is_arc()) rapid_ = false;
  if (!words.m.empty() || words.has(40) || words.has(100)) return QueueWait(words);
  if (!words.moves()) {
    // S alone: M3 takes it at rest, in G1.
    if (words.s && motion_.is_empty()) CommandSpindle(spindle_);
    return Answer(0);
  }
  if (power_ > 0) motion_powers_.push_back(power_);
  if (const int bad = QueueMotion(words, false)) Answer(bad);
}

// grblHAL checks none of its limits before it was homed.
bool VirtualGrbl::range_is_checked() const {
  return options_.soft_limits && (!options_.hal || homed_);
}

int VirtualGrbl::CheckRange(const Vec3& machine_mm, bool jog) {
  if (!range_is_checked()) return 0;
  const bool inside = (machine_mm.array() >= options_.travel_min_mm.array()).all() &&
                      (machine_mm.array() <= options_.travel_max_mm.array()).all();
  if (inside) return 0;
  if (jog) return kTravelExceeded;
  RaiseAlarm(2);
  mute_ = true;
  return -1;
}

int VirtualGrbl::QueueMotion(const GcodeLine& words, bool jog) {
  const bool absolute =
      jog ? (words.has(900) || (absolute_ && !words.has(910))) : absolute_;
  const bool rapid = !jog && rapid_;
  const double feed = jog ? *words.f : feed_mm_min_;
  if (!rapid && feed <= 0) return kNoFeed;
  Waiting wait;
  wait.reason = Waiting::For::kRoom;
  const Steps& end = motion_.planned_end();
  Vec3 machine_mm;
  for (int i = 0; i < 3; ++i) {
    const double from = static_cast<double>(end[i]) / options_.motion.steps_per_mm;
    machine_mm[i] = from;
    if (words.x[i]) {
      machine_mm[i] = *words.x[i] + (absolute ? work_offset_mm_[i] : from);
    }
    // As far as its step counter goes.
    const double steps = machine_mm[i] * options_.motion.steps_per_mm;
    wait.target[i] = std::llround(std::clamp(steps, -2147483648.0, 2147483647.0));
  }
  if (const int bad = CheckRange(machine_mm, jog)) return bad;
  if (words.is_arc()) {
    if (const int bad = AddChords(words, machine_mm, wait)) return bad;
  }
  wait.speed_mm_s = rapid ? options_.motion.max_speed_mm_s : feed / 60;
  wait.beam = BeamOf(rapid);
  wait.power = power_;
  wait.jog = jog;
  wait.line = words.n;
  waiting_ = wait;
  return 0;
}

// gcode.c and motion_control.c, mc_arc: the radius is checked, then chords are made. The
// modal state of an arc is not: every line names its own.
int VirtualGrbl::AddChords(const GcodeLine& words, const Vec3& to_mm,
                           Waiting& wait) const {
  if (!words.i && !words.j) return kBadArc;
  const double per_mm = options_.motion.steps_per_mm;
  const Steps& end = motion_.planned_end();
  const Vec2 from(double(end[0]) / per_mm, double(end[1]) / per_mm);
  const Vec2 center = from + Vec2(words.i.value_or(0), words.j.value_or(0));
  const Vec2 out = from - center, to = to_mm.head<2>() - center;
  const double radius = out.norm(), off = std::abs(to.norm() - radius);
  if (off > 0.005 && (off > 0.5 || off > 0.001 * radius)) return kBadArc;
  double sweep = std::atan2(out.x() * to.y() - out.y() * to.x(), out.dot(to));
  constexpr double kTurn = 2 * 3.14159265358979323846;
  if (words.has(20) && sweep >= -5e-7) sweep -= kTurn;
  if (words.has(30) && sweep <= 5e-7) sweep += kTurn;
  const int chords = static_cast<int>(
      std::abs(0.5 * sweep * radius) /
      std::sqrt(options_.arc_tolerance_mm * (2 * radius - options_.arc_tolerance_mm)));
  const Steps target = wait.target;
  for (int k = 1; k < chords; ++k) {
    const Vec2 place = center + Eigen::Rotation2Dd(sweep * k / chords) * out;
    const double z = double(end[2]) + double(target[2] - end[2]) * k / chords;
    wait.later.push_back({std::llround(place.x() * per_mm),
                          std::llround(place.y() * per_mm), std::llround(z)});
  }
  wait.later.push_back(target);
  wait.target = wait.later.front();
  wait.later.pop_front();
  return 0;
}

// M3, M4, M5, G4 and G10 wait until the planner is empty; M64 and M65 act when they are
// parsed.
void VirtualGrbl::QueueWait(const GcodeLine& words) {
  Waiting wait;
  for (const int code : words.m) {
    if (code == 30) wait.spindle = Spindle::kConstant;
    if (code == 40) wait.spindle = Spindle::kDynamic;
    if (code == 50) wait.spindle = Spindle::kOff;
    if (code == 640 || code == 650) {
      output_on_ = code == 640;
      output_at_ = motion_.at();
      return Answer(0);
    }
    if (code == 620 || code == 630) {
      if (!options_.hal) return Answer(kUnsupported);
      crashed_ = true;
      return;
    }
    if (code != 30 && code != 40 && code != 50) return Answer(kUnsupported);
  }
  if (words.has(40)) {
    if (!words.p) return Answer(28);
    wait.dwell_us = std::max(kMinDwell_us, *words.p * 1e6);
  }
  if (words.has(100)) {
    if (words.l != 20) return Answer(kUnsupported);
    wait.sets_offset = true;
    for (int i = 0; i < 3; ++i) {
      const double at =
          static_cast<double>(motion_.planned_end()[i]) / options_.motion.steps_per_mm;
      wait.offset_mm[i] = words.x[i] ? at - *words.x[i] : work_offset_mm_[i];
    }
  }
  waiting_ = wait;
}

}  // namespace intaglio::grbl
