#pragma once

// A virtual grbl at the driver of marks: what it reports, and what the tool really does.

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/grbl/marks/grbl_course_driver.h"
#include "tests/services/drivers/grbl/grbl_rig.h"

namespace intaglio::drivers {

/// A place of the tool that was seen, every millisecond.
struct SeenPlace {
  Vec3 at_mm;
  bool lit = false;  ///< of a laser
  std::uint32_t mark = 0;
  bool in_hand = false;  ///< a mark is begun and not ended
};

class CourseRig {
 public:
  using Change = void (*)(grbl::VirtualGrblOptions&);
  explicit CourseRig(CourseToolKind kind, const std::string& serial_number = "",
                     Change change = nullptr);

  /// 1 ms: the controller, then the host, which permits while it is told to.
  void Step();
  void StepFor(std::chrono::milliseconds time);
  /// False: it has not come within 300 s of the rig's time.
  template <typename Condition>
  bool StepUntil(Condition condition) {
    for (int i = 0; i < 300'000; ++i) {
      if (condition()) return true;
      Step();
    }
    return false;
  }
  bool Ready() {
    return StepUntil([&] { return driver->state().link_up && driver->state().settled; });
  }
  /// Appends all as there is room, and finishes; until the run has ended.
  bool Run(std::uint32_t run, const mark::MarkSet& set, std::uint32_t first = 0);
  void MakeDriver();

  std::size_t CountOf(MarkFate fate) const;
  std::optional<MarkFate> LastOf(std::uint32_t mark) const;
  bool moves() const { return !machine.grbl.motion().is_empty(); }
  bool lit() const { return machine.grbl.motion().lit(); }

  GrblMachine machine;
  MachineSpec profile;
  std::unique_ptr<MarkDriver> driver;
  bool permits = true;
  std::vector<MarkEvent> events;
  std::vector<SeenPlace> seen;
  /// Marks of which something moved at work before its kBegun had come; K3.
  std::size_t early_count = 0;

 private:
  void Take();
  std::optional<std::uint32_t> in_hand_;
};

MachineSpec CourseProfile(CourseToolKind kind);

mark::Pen LaserPen();
/// 0.6 mm in three passes.
mark::Pen MillPen();
mark::Mark SquareAt(double x, double y, double side);
/// Squares of 2 mm, side by side.
mark::MarkSet Squares(const mark::Pen& pen, int count);

/// The distance of a place from a mark, by the chords that engrave/mark makes.
double DistanceToMark(const Vec2& p, const mark::Mark& mark);

/// The farthest place of a mark from every place of `seen` that `at_work` picks.
template <typename AtWork>
double FarthestMissed(const mark::Mark& mark, std::uint32_t number,
                      const std::vector<SeenPlace>& seen, AtWork at_work) {
  double farthest = 0;
  for (const Vec2& place : mark::PlacesOf(mark, 1e-4)) {
    double nearest = 1e9;
    for (const SeenPlace& one : seen) {
      if (one.in_hand && one.mark == number && at_work(one))
        nearest = std::min(nearest, (one.at_mm.head<2>() - place).norm());
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

}  // namespace intaglio::drivers
