#include "engrave/motion/planner.h"

#include "engrave/motion/commands/drive_compensation.h"
#include "engrave/motion/stop_and_go.h"
#include "engrave/motion/tick_planner.h"

namespace intaglio::motion {
namespace {

class Stopping : public Planner {
 public:
  Stopping(const PlanOptions& options, const Vec3& start_mm)
      : planner_(options.limits, options.rate_hz, options.profile, start_mm,
                 options.program) {}

  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out) override {
    planner_.Append(target_mm, point, pulse, out);
  }
  void Finish(std::vector<Segment>& out) override { planner_.Finish(out); }
  std::uint64_t ticks() const override { return planner_.ticks(); }

 private:
  StopAndGoPlanner planner_;
};

/// The travel minus the lead of the commands over the stage where it brakes.
Limits LimitsOfPlan(const PlanOptions& options) {
  Limits limits = options.limits;
  if (!options.drive) return limits;
  const Vec3 lead_mm = options.drive->lead_s2() * limits.max_acceleration_mm_s2;
  limits.travel_mm.min_mm += lead_mm;
  limits.travel_mm.max_mm -= lead_mm;
  return limits;
}

TickPlannerOptions PlannerOptionsOf(const PlanOptions& options) {
  TickPlannerOptions of_planner = OptionsForRate(options.rate_hz);
  of_planner.tolerance_mm = options.tolerance_mm;
  return of_planner;
}

class Continuous : public Planner {
 public:
  Continuous(const PlanOptions& options, const Vec3& start_mm)
      : planner_(LimitsOfPlan(options), options.rate_hz, PlannerOptionsOf(options),
                 {start_mm, Vec3::Zero()}),
        compensation_(options.drive.get(), options.rate_hz, {start_mm, Vec3::Zero()}) {}

  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out) override {
    planner_.Append(target_mm, point, pulse, planned_);
    Pass(out);
  }
  void Finish(std::vector<Segment>& out) override {
    planner_.Finish(planned_);
    Pass(out);
    compensation_.Finish(out);
  }
  std::uint64_t ticks() const override {
    return planner_.ticks() + compensation_.tail_ticks();
  }
  PointMoves moves() const override { return planner_.moves(); }

 private:
  void Pass(std::vector<Segment>& out) {
    for (const Segment& segment : planned_) compensation_.Append(segment, out);
    planned_.clear();
  }

  TickPlanner planner_;
  DriveCompensation compensation_;
  std::vector<Segment> planned_;
};

}  // namespace

std::unique_ptr<Planner> MakePlanner(const PlanOptions& options, const Vec3& start_mm) {
  if (options.continuous) return std::make_unique<Continuous>(options, start_mm);
  return std::make_unique<Stopping>(options, start_mm);
}

}  // namespace intaglio::motion
