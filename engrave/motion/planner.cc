#include "engrave/motion/planner.h"

#include "engrave/motion/lag_compensation.h"
#include "engrave/motion/stop_and_go.h"
#include "engrave/motion/tick_planner.h"

namespace intaglio::motion {
namespace {

class Stopping : public Planner {
 public:
  Stopping(const PlanOptions& options, const Vec3& start_mm)
      : planner_(options.limits, options.rate_hz, options.profile, start_mm) {}

  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out) override {
    planner_.Append(target_mm, point, pulse, out);
  }
  void Finish(std::vector<Segment>& out) override { planner_.Finish(out); }
  std::uint64_t ticks() const override { return planner_.ticks(); }

 private:
  StopAndGoPlanner planner_;
};

class Continuous : public Planner {
 public:
  Continuous(const PlanOptions& options, const Vec3& start_mm)
      : planner_(options.limits, options.rate_hz, OptionsForRate(options.rate_hz),
                 {start_mm, Vec3::Zero()}),
        compensation_(options.stage_lag_s, options.rate_hz, {start_mm, Vec3::Zero()}) {}

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
  std::uint64_t ticks() const override { return planner_.ticks(); }

 private:
  void Pass(std::vector<Segment>& out) {
    for (const Segment& segment : planned_) compensation_.Append(segment, out);
    planned_.clear();
  }

  TickPlanner planner_;
  LagCompensation compensation_;
  std::vector<Segment> planned_;
};

}  // namespace

std::unique_ptr<Planner> MakePlanner(const PlanOptions& options, const Vec3& start_mm) {
  if (options.continuous) return std::make_unique<Continuous>(options, start_mm);
  return std::make_unique<Stopping>(options, start_mm);
}

}  // namespace intaglio::motion
