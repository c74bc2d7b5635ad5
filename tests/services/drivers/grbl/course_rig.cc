#include "tests/services/drivers/grbl/course_rig.h"

#include <algorithm>

namespace intaglio::drivers {
namespace {

grbl::VirtualGrblOptions OptionsFor(CourseToolKind kind, CourseRig::Change change) {
  grbl::VirtualGrblOptions options = grbl::Grbl11();
  // So fine that rounding to steps is below what is compared.
  options.motion.steps_per_mm = 10000;
  options.motion.acceleration_mm_s2 = 1000;
  options.arc_tolerance_mm = 0.001;
  options.laser_mode = kind == COURSE_TOOL_LASER;
  if (change != nullptr) change(options);
  return options;
}

double DistanceToChord(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 way = b - a;
  const double t = std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (a + t * way - p).norm();
}

}  // namespace

MachineSpec CourseProfile(CourseToolKind kind) {
  MachineSpec machine;
  machine.set_name("mill");
  machine.mutable_mark_line()->set_protocol("grbl-course");
  machine.mutable_mark_line()->set_device("the line");
  CourseTool& tool = *machine.mutable_course_tool();
  tool.set_kind(kind);
  if (kind == COURSE_TOOL_SPINDLE) {
    tool.set_spindle_rpm(900);  // of the virtual controller's $30=1000
    tool.set_spin_up_s(0.2);
    tool.set_safe_height_mm(2);
  }
  return machine;
}

mark::Pen LaserPen() {
  mark::Pen pen;
  pen.name = "cut";
  pen.speed_mm_s = 20;
  pen.power_ratio = 0.4;
  return pen;
}

mark::Pen MillPen() {
  mark::Pen pen;
  pen.name = "mill";
  pen.speed_mm_s = 20;
  pen.plunge_mm_s = 10;
  pen.depth_mm = 0.6;
  pen.pass_count = 3;
  return pen;
}

mark::Mark SquareAt(double x, double y, double side) {
  mark::Mark mark;
  mark.closed = true;
  mark.places = {{{x, y}}, {{x + side, y}}, {{x + side, y + side}}, {{x, y + side}}};
  return mark;
}

double DistanceToMark(const Vec2& p, const mark::Mark& mark) {
  const auto chords = mark::PlacesOf(mark, 1e-5);
  if (chords.size() == 1) return (p - chords[0]).norm();
  double nearest = 1e9;
  for (std::size_t i = 0; i + (mark.closed ? 0 : 1) < chords.size(); ++i)
    nearest =
        std::min(nearest, DistanceToChord(p, chords[i], chords[(i + 1) % chords.size()]));
  return nearest;
}

mark::MarkSet Squares(const mark::Pen& pen, int count) {
  mark::MarkSet set{{pen}, {}};
  for (int i = 0; i < count; ++i) set.marks.push_back(SquareAt(3.0 * i, 1, 2));
  return set;
}

CourseRig::CourseRig(CourseToolKind kind, const std::string& serial_number, Change change)
    : machine(OptionsFor(kind, change)), profile(CourseProfile(kind)) {
  if (!serial_number.empty())
    profile.mutable_mark_line()->set_serial_number(serial_number);
  MakeDriver();
}

void CourseRig::MakeDriver() {
  driver = MakeGrblCourseDriver(profile, machine.opener(), machine.clock());
}

void CourseRig::Take() {
  for (const MarkEvent& event : driver->TakeEvents()) {
    events.push_back(event);
    if (event.fate == MarkFate::kBegun)
      in_hand_ = event.mark;
    else if (in_hand_ == event.mark)
      in_hand_.reset();
  }
}

void CourseRig::Step() {
  const auto steps = machine.grbl.motion().steps_made();
  machine.Advance();
  SeenPlace place;
  place.at_mm = machine.grbl.WorkPosition_mm();
  place.lit = lit();
  place.in_hand = in_hand_.has_value();
  place.mark = in_hand_.value_or(0);
  if (machine.grbl.motion().steps_made() != steps && !place.in_hand) ++early_count;
  seen.push_back(place);
  if (permits) (void)driver->Permit(true);
  driver->Poll();
  Take();
}

void CourseRig::StepFor(std::chrono::milliseconds time) {
  for (auto i = time.count(); i > 0; --i) Step();
}

bool CourseRig::Run(std::uint32_t run, const mark::MarkSet& set, std::uint32_t first) {
  if (!driver->Begin(run, set.pens)) return false;
  std::uint32_t next = first;
  return StepUntil([&] {
    while (next < first + set.marks.size() && driver->Room() > 0) {
      if (!driver->Append({next, set.marks[next - first]})) return false;
      if (++next == first + set.marks.size()) (void)driver->Finish();
    }
    return next == first + set.marks.size() && driver->state().settled;
  });
}

std::size_t CourseRig::CountOf(MarkFate fate) const {
  return static_cast<std::size_t>(std::ranges::count(events, fate, &MarkEvent::fate));
}

std::optional<MarkFate> CourseRig::LastOf(std::uint32_t mark) const {
  std::optional<MarkFate> fate;
  for (const MarkEvent& event : events) {
    if (event.mark == mark) fate = event.fate;
  }
  return fate;
}

}  // namespace intaglio::drivers
