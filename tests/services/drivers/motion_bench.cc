#include "tests/services/drivers/motion_bench.h"

namespace intaglio::drivers {

void MotionBench::ExpectGoodRun(std::uint32_t run) {
  const Course course = CourseFromHere();
  positions.clear();
  const std::uint64_t start = Begin(run);
  Append(course.Segments());
  Expect(Until([&] { return state().run == run && !state().at_rest; }),
         "M2: the run is not reported: " + Message());
  Expect(Until([&] { return state().at_rest; }), "M4: the run does not end");
  StepFor(kReportTime);
  Expect(state().fault == intaglio_MOTION_OK, "M4: a good run is a fault: " + Message());
  Expect(std::abs(x() - course.end_mm()) <= rig_->tolerance_mm(),
         fmt::format("M4: the run ends at {}, not {}", x(), course.end_mm()));
  Expect((state().position_mm - rig_->actual_mm()).norm() <= rig_->tolerance_mm(),
         "M2: the reported position is not where the stage is");
  std::uint64_t tick = start + 1;
  for (const LatchedPositions& part : positions) {
    for (std::size_t i = 0; i < part.positions_mm.size(); ++i) {
      // By a clock of its own, ticks before and behind a run are reported, too.
      const bool in_run =
          part.first_tick + i > start && tick < start + 1 + course.ticks();
      if (!part.at_ns.empty() && !in_run) continue;
      Expect(part.run == run, "M12: positions of another run");
      Expect(part.first_tick + i == tick,
             fmt::format("M12: the position of tick {} follows that of tick {}",
                         part.first_tick + i, tick - 1));
      const Vec3& p = part.positions_mm[i];
      const double planned = course.At(static_cast<std::uint32_t>(tick - start));
      Expect((p - Vec3(planned, 0, 0)).norm() <= rig_->tolerance_mm(),
             fmt::format("M4, M12: at tick {} of the run x is {}, not {}", tick - start,
                         p.x(), planned));
      ++tick;
    }
  }
  Expect(tick == start + 1 + course.ticks(),
         fmt::format("M12: {} positions of {} ticks", tick - start - 1, course.ticks()));
}

}  // namespace intaglio::drivers
