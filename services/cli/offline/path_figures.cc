#include "services/cli/offline/path_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"
#include "engrave/motion/verify.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/job/convert/options.h"
#include "services/job/files/json_text.h"
#include "services/job/machine/job_ticks_bound.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/predicted_errors.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

// Points planned between two reads of the clock: the planners return some hundreds of
// points at once.
constexpr std::size_t kPointsATime = 4096;

/// The same limits for axes counted in millimetres of the focus.
motion::Limits AtFocus(motion::Limits limits, const Vec3& focus_mm) {
  limits.max_speed_mm_s = limits.max_speed_mm_s.cwiseProduct(focus_mm);
  limits.max_acceleration_mm_s2 = limits.max_acceleration_mm_s2.cwiseProduct(focus_mm);
  limits.max_jerk_mm_s3 = limits.max_jerk_mm_s3.cwiseProduct(focus_mm);
  limits.travel_mm.min_mm = limits.travel_mm.min_mm.cwiseProduct(focus_mm);
  limits.travel_mm.max_mm = limits.travel_mm.max_mm.cwiseProduct(focus_mm);
  return limits;
}

/// Passes a plan on piece by piece, and measures the planner alone. It is verified with
/// the axes counted in millimetres of the focus, `bounds` a unit, so that the figures of
/// an axis in rad are those of a machine; of linear axes they are the axes' own.
class MotionMeter {
 public:
  MotionMeter(const motion::PlanOptions& plan, const PointList& path,
              const machine::ScaleBounds& bounds, const SegmentSink& sink)
      : rate_hz_(plan.rate_hz),
        bounds_(bounds),
        sink_(sink),
        plan_(plan, path.front(),
              [this](std::span<const motion::Segment> segments) { PassOn(segments); }),
        verified_mm_(path) {
    for (Vec3& point : verified_mm_) point = AtFocus(point);
    motion::VerifyOptions options;
    options.position_tolerance_mm +=
        plan.tolerance_mm * bounds.any_mm + plan.sweep_mm * bounds.axis_mm.z();
    verifier_.emplace(motion::KnotState{verified_mm_.front(), Vec3::Zero()}, verified_mm_,
                      cli::AtFocus(plan.limits, bounds.axis_mm), plan.rate_hz, options);
  }

  Status Plan(const PointList& path_mm, std::size_t begin, std::size_t end) {
    const auto began = Clock::now();
    for (std::size_t i = begin; i < end; ++i) plan_.Append(path_mm[i]);
    if (end == path_mm.size()) plan_.Rest();
    planning_ += Clock::now() - began;
    return status_;
  }

  PlannedMotion Finish(std::size_t point_count) {
    const motion::MotionReport report = verifier_->Finish();
    const auto points = static_cast<double>(point_count);
    const auto ticks = subticks_of_last_point_ / motion::kSubticksPerTick;
    PlannedMotion planned;
    planned.set_ticks(ticks);
    planned.set_machining_time_s(static_cast<double>(ticks) / rate_hz_);
    planned.set_utilisation(points /
                            static_cast<double>(std::max<std::uint64_t>(ticks, 1)));
    planned.set_rms_acceleration_mm_s2(report.rms_acceleration_mm_s2);
    planned.set_peak_acceleration_mm_s2(report.peak_acceleration_mm_s2);
    planned.set_mean_jerk_mm_s3(report.mean_jerk_mm_s3);
    planned.set_peak_speed_mm_s(report.max_speed_mm_s.maxCoeff());
    planned.set_violation_count(report.violation_count);
    planned.mutable_violations()->Assign(report.violations.begin(),
                                         report.violations.end());
    planned.set_segment_count(segment_count_);
    planned.set_max_move_um(1e3 * plan_.moves().max_mm * bounds_.any_mm);
    planned.set_planned_points_per_s(
        points / std::max(1e-9, std::chrono::duration<double>(planning_).count()));
    return planned;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void PassOn(std::span<const motion::Segment> segments) {
    const auto began = Clock::now();
    for (const motion::Segment& segment : segments) {
      verifier_->Append(AtFocus(segment));
      subticks_ += segment.duration_subticks;
      if (segment.point >= 0) subticks_of_last_point_ = subticks_;
      if (status_) status_ = sink_(segment);
    }
    segment_count_ += segments.size();
    planning_ -= Clock::now() - began;
  }
  Vec3 AtFocus(const Vec3& axes) const { return axes.cwiseProduct(bounds_.axis_mm); }
  motion::Segment AtFocus(motion::Segment segment) const {
    segment.end_position_mm = AtFocus(segment.end_position_mm);
    segment.end_velocity_mm_s = AtFocus(segment.end_velocity_mm_s);
    return segment;
  }

  double rate_hz_;
  machine::ScaleBounds bounds_;
  const SegmentSink& sink_;
  motion::PointPlan plan_;
  PointList verified_mm_;
  std::optional<motion::MotionVerifier> verifier_;
  Status status_;  ///< of the sink
  Clock::duration planning_{};
  std::uint64_t subticks_ = 0, subticks_of_last_point_ = 0, segment_count_ = 0;
};

std::string Grouped(double number) {
  return client::GroupedDigits(static_cast<std::uint64_t>(std::llround(number)));
}

}  // namespace

PlanReport DescribePath(const FrozenJob& job, const PointList& path_mm) {
  Require(!path_mm.empty(), "a path without points");
  PlanReport report;
  report.set_point_count(path_mm.size());
  report.set_checksum(client::PointChecksum(path_mm));
  report.set_shadow_violation_count(
      sort::CountShadowViolations(path_mm, PointConeOf(job)));
  sort::Order as_given(path_mm.size());
  std::iota(as_given.begin(), as_given.end(), 0);
  const sort::Travel travel = sort::MeasureTravel(path_mm, as_given);
  report.set_travel_mm(travel.largest_axis_mm);
  report.set_longest_step_mm(travel.longest_step_mm);
  const motion::PlanOptions plan = MotionOptionsOf(job);
  report.set_machine(job.machine().name());
  report.set_rate_hz(plan.rate_hz);
  report.set_position_tolerance_um(job.machine().position_tolerance_um());
  const motion::Limits limits = AtFocus(plan.limits, ScaleBoundsOf(job).axis_mm);
  report.set_max_speed_mm_s(limits.max_speed_mm_s.minCoeff());
  report.set_max_acceleration_mm_s2(limits.max_acceleration_mm_s2.minCoeff());
  return report;
}

Result<PlannedMotion> PlanMotion(const FrozenJob& job, const PointList& path,
                                 const SegmentSink& sink, const ProgressSink& progress,
                                 std::vector<double>* errors_um) {
  Require(!path.empty(), "a path without points");
  motion::PlanOptions plan = MotionOptionsOf(job);
  plan.compensated = false;
  PredictedErrors predicted(job, path);
  const SegmentSink predict_and_sink = [&](const motion::Segment& segment) -> Status {
    predicted.Append(segment);
    return sink ? sink(segment) : Status{};
  };
  MotionMeter meter(plan, path, ScaleBoundsOf(job), predict_and_sink);
  for (std::size_t begin = 0; begin < path.size(); begin += kPointsATime) {
    const std::size_t end = std::min(begin + kPointsATime, path.size());
    INTAGLIO_TRY(meter.Plan(path, begin, end));
    if (progress && !progress(end, path.size())) {
      return Fail(ErrorCode::kCancelled, "the plan was ended early");
    }
  }
  PlannedMotion planned = meter.Finish(path.size());
  planned.set_planner(ProfileName(job.job().motion().profile()));
  predicted.Finish();
  if (predicted.predicts()) {
    planned.set_predicted_rms_error_um(predicted.rms_um());
    planned.set_predicted_max_error_um(predicted.max_um());
    planned.set_wrong_mechanics_max_error_um(predicted.wrong_mechanics_max_um());
  }
  if (const auto bound = JobTicksBound(job.machine(), path, plan, host::AllCores())) {
    planned.set_ticks_bound(*bound);
  }
  if (errors_um != nullptr) *errors_um = predicted.errors_um();
  return planned;
}

std::vector<FrozenJob> WithOtherPlanners(const FrozenJob& job) {
  std::vector<FrozenJob> jobs;
  const auto* profiles = MotionProfile_descriptor();
  for (int i = 0; i < profiles->value_count(); ++i) {
    const auto profile = static_cast<MotionProfile>(profiles->value(i)->number());
    if (profile == job.job().motion().profile()) continue;
    jobs.push_back(job);
    jobs.back().mutable_job()->mutable_motion()->set_profile(profile);
  }
  return jobs;
}

bool IsSound(const PlanReport& report) {
  return report.shadow_violation_count() == 0 &&
         (report.motions().empty() || report.motions(0).violation_count() == 0);
}

std::string FiguresOf(const PlanReport& report) {
  Require(!report.motions().empty(), "a report without a motion");
  const PlannedMotion& m = report.motions(0);
  std::string text = fmt::format(
      "path          {}, {} fired through an earlier crack, checksum {}\n"
      "travel        {} mm, the longest axis of each step; longest step {:.2f} mm\n"
      "motion        {}, {} at {:g} Hz, {:g} mm/s, {:g} mm/s^2\n"
      "time          {}, {}{}\n"
      "utilisation   {:.4f} points a tick\n"
      "violations    {} of limits, places or ticks\n"
      "acceleration  {} mm/s^2 rms, {} mm/s^2 peak\n"
      "jerk          {} mm/s^3 mean\n"
      "speed         {:.1f} mm/s peak of an axis\n"
      "planned       {}, {} points/s",
      client::GroupedCount(report.point_count(), "point"),
      client::GroupedDigits(report.shadow_violation_count()), report.checksum(),
      Grouped(report.travel_mm()), report.longest_step_mm(), m.planner(),
      report.machine(), report.rate_hz(), report.max_speed_mm_s(),
      report.max_acceleration_mm_s2(), client::ShortDuration(m.machining_time_s()),
      client::GroupedCount(m.ticks(), "tick"),
      m.has_ticks_bound() ? client::AboveBound(m.ticks(), m.ticks_bound()) : "",
      m.utilisation(), client::GroupedDigits(m.violation_count()),
      Grouped(m.rms_acceleration_mm_s2()), Grouped(m.peak_acceleration_mm_s2()),
      Grouped(m.mean_jerk_mm_s3()), m.peak_speed_mm_s(),
      client::GroupedCount(m.segment_count(), "segment"),
      client::ShortNumber(m.planned_points_per_s()));
  if (m.max_move_um() > 0) {
    text += fmt::format("\nmoves         {:.2f} um at most, of a point", m.max_move_um());
  }
  if (m.has_predicted_rms_error_um()) {
    text += fmt::format(
        "\nprediction    {:.2f} um rms, {:.2f} um at most beside the points, by the "
        "profile's drive",
        m.predicted_rms_error_um(), m.predicted_max_error_um());
    const double wrong_um = m.wrong_mechanics_max_error_um();
    const double tolerance_um = report.position_tolerance_um();
    text += fmt::format(
        "\nmargin        {:.2f} um at most with the drive 5 % off in frequency or 20 % "
        "in "
        "damping: {} the tolerance of {:g} um",
        wrong_um, wrong_um <= tolerance_um ? "within" : "BEYOND", tolerance_um);
  }
  for (const std::string& violation : m.violations()) {
    text += "\n  " + violation;
  }
  return text;
}

std::string ComparisonOf(const PlanReport& report) {
  std::string text = fmt::format(
      "{:<13} {:>11} {:>15} {:>12} {:>11} {:>11} {:>13} {:>11} {:>15}\n"
      "{:<13} {:>11} {:>15} {:>12} {:>11} {:>11} {:>13} {:>11} {:>15}",
      "planner", "ticks", "time", "utilisation", "rms accel.", "peak accel.", "mean jerk",
      "violations", "planned", "", "", "", "points/tick", "mm/s^2", "mm/s^2", "mm/s^3",
      "", "points/s");
  for (const PlannedMotion& m : report.motions()) {
    text += fmt::format(
        "\n{:<13} {:>11} {:>15} {:>12.4f} {:>11} {:>11} {:>13} {:>11} {:>15}",
        m.planner(), client::GroupedDigits(m.ticks()),
        client::ShortDuration(m.machining_time_s()), m.utilisation(),
        Grouped(m.rms_acceleration_mm_s2()), Grouped(m.peak_acceleration_mm_s2()),
        Grouped(m.mean_jerk_mm_s3()), client::GroupedDigits(m.violation_count()),
        Grouped(m.planned_points_per_s()));
  }
  return text;
}

std::string JsonOf(const PlanReport& report) {
  const auto json = JsonTextOf(report);
  Require(json.has_value(), "the plan's report cannot be written: {}",
          json ? "" : json.error().message);
  return *json;
}

}  // namespace intaglio::cli
