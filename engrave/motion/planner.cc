#include "engrave/motion/planner.h"

#include "engrave/motion/commands/drive_compensation.h"
#include "engrave/motion/commands/error_judge.h"
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
  Vec3 lead_mm = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const auto& drive = options.drives[static_cast<std::size_t>(axis)];
    if (drive) lead_mm[axis] = drive->lead_s2() * limits.max_acceleration_mm_s2[axis];
  }
  limits.travel_mm.min_mm += lead_mm;
  limits.travel_mm.max_mm -= lead_mm;
  return limits;
}

/// Down to a thirtieth.
constexpr int kAccelerationLevels = 13;
/// A window is planned in one turn of the synchronizer, whose laser line must not be left
/// alone for 250 ms: a drive of fifth order is followed over some 10 000 points a second.
constexpr int kJudgedWindow = 128, kJudgedLookAhead = 32;

/// What a drive leaves of the greatest jump of the acceleration, in the axis' unit:
/// lag^2 J / 2 of first order (drive_compensation.h), of others it is not known
/// beforehand.
double LeftBy(const drive::Drive* drive, double max_acceleration) {
  if (drive == nullptr) return 0;
  if (drive->name() != "first_order") return kUnlimited;
  const double lag_s = drive->transfer().denominator[1];
  return lag_s == 0 ? 0 : lag_s * lag_s * max_acceleration;
}

/// Whether the drives may leave more than the limit.
bool IsJudged(const PlanOptions& options) {
  if (!(options.error_limit > 0)) return false;
  double left = 0;
  for (int axis = 0; axis < 3; ++axis) {
    left += LeftBy(options.drives[static_cast<std::size_t>(axis)].get(),
                   options.limits.max_acceleration_mm_s2[axis]);
  }
  constexpr double kSure = 0.5;
  return left > kSure * options.error_limit;
}

TickPlannerOptions PlannerOptionsOf(const PlanOptions& options) {
  TickPlannerOptions of_planner = OptionsForRate(options.rate_hz);
  of_planner.tolerance_mm = options.tolerance_mm;
  of_planner.sweep_mm = options.sweep_mm;
  if (IsJudged(options)) {
    of_planner.acceleration_levels = kAccelerationLevels;
    of_planner.window_points = kJudgedWindow;
    of_planner.look_ahead_points = kJudgedLookAhead;
  }
  return of_planner;
}

class Continuous : public Planner {
 public:
  Continuous(const PlanOptions& options, const Vec3& start_mm)
      : planner_(LimitsOfPlan(options), options.rate_hz, PlannerOptionsOf(options),
                 {start_mm, Vec3::Zero()}),
        compensated_(options.compensated),
        compensation_(options.drives, options.rate_hz, {start_mm, Vec3::Zero()}) {
    if (!IsJudged(options)) return;
    judge_ = std::make_unique<ErrorJudge>(options.drives, options.rate_hz, start_mm,
                                          options.error_limit);
    planner_.SetJudge(judge_.get());
  }

  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out) override {
    planner_.Append(target_mm, point, pulse, planned_);
    Pass(out);
  }
  void Finish(std::vector<Segment>& out) override {
    planner_.Finish(planned_);
    Pass(out);
    if (compensated_) compensation_.Finish(out);
  }
  std::uint64_t ticks() const override {
    return planner_.ticks() + compensation_.tail_ticks();
  }
  PointMoves moves() const override { return planner_.moves(); }

 private:
  void Pass(std::vector<Segment>& out) {
    for (const Segment& segment : planned_) {
      if (judge_) judge_->Receive(segment);
      if (compensated_) {
        compensation_.Append(segment, out);
      } else {
        out.push_back(segment);
      }
    }
    planned_.clear();
  }

  TickPlanner planner_;
  bool compensated_;
  DriveCompensation compensation_;
  std::unique_ptr<ErrorJudge> judge_;
  std::vector<Segment> planned_;
};

}  // namespace

bool KeepsMore(const PlanOptions& options) {
  const Limits& limits = options.limits;
  return limits.max_jerk_mm_s3.minCoeff() < kUnlimited ||
         limits.max_speed_norm_mm_s < kUnlimited ||
         limits.max_acceleration_norm_mm_s2 < kUnlimited || IsJudged(options);
}

std::unique_ptr<Planner> MakePlanner(const PlanOptions& options, const Vec3& start_mm) {
  if (options.continuous) return std::make_unique<Continuous>(options, start_mm);
  return std::make_unique<Stopping>(options, start_mm);
}

}  // namespace intaglio::motion
