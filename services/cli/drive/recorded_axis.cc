#include "services/cli/drive/recorded_axis.h"

#include <algorithm>
#include <map>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/motion/segments/segment.h"
#include "services/platform/bus/topics.h"
#include "services/replayer/cell/cell_session.h"
#include "services/replayer/recorded_members.h"

// A segment is cut at the ticks within it, for positions are known there: the command is
// the cubic Hermite curve from the knot before, moved to the cut.

namespace intaglio::cli {
namespace {

constexpr const char* kPositionColumns[] = {"x_mm", "y_mm", "z_mm"};

/// Positions of an axis by tick, of one run.
Result<std::map<std::uint64_t, double>> PositionsOf(const recording::McapReader& reader,
                                                    std::size_t axis, std::uint32_t run) {
  std::map<std::uint64_t, double> positions;
  replayer::RecordedValues values(reader, bus::kPositionReport.name);
  while (true) {
    const auto value = INTAGLIO_TRY(values.Next());
    if (!value) return positions;
    std::uint32_t of_run = 0;
    std::uint64_t first_tick = 0;
    std::vector<double> column;
    std::vector<std::uint64_t> at_ns;
    replayer::Members members(*value);
    members.Get("run", of_run);
    members.Get("first_tick", first_tick);
    members.Get(kPositionColumns[axis], column);
    members.Get("at_ns", at_ns);
    if (!members.good() || of_run != run) continue;
    if (!at_ns.empty()) {
      return Fail(ErrorCode::kUnsupported,
                  "the stage has a clock of its own: its positions are not those of the "
                  "lamp's ticks; record the axis with another instrument");
    }
    for (std::size_t i = 0; i < column.size(); ++i) positions[first_tick + i] = column[i];
  }
}

/// The run with the most segments, and the task that it is of.
Result<std::pair<const replayer::CellSession*, const replayer::CellRun*>> LongestRun(
    const std::vector<replayer::CellSession>& sessions) {
  std::pair<const replayer::CellSession*, const replayer::CellRun*> longest = {nullptr,
                                                                               nullptr};
  for (const replayer::CellSession& session : sessions) {
    for (const replayer::CellRun& run : session.messages.runs) {
      if (run.duration_subticks.empty()) continue;
      if (longest.second == nullptr ||
          run.duration_subticks.size() > longest.second->duration_subticks.size())
        longest = {&session, &run};
    }
  }
  if (longest.second != nullptr) return longest;
  return Fail(ErrorCode::kMissing,
              "the recording has no motion of a job; record a job that is engraved");
}

drive::Cubic Behind(const drive::Cubic& c, double t_s) {
  return {c.At(t_s), c.VelocityAt(t_s), c.acceleration_u_s2 + t_s * c.jerk_u_s3,
          c.jerk_u_s3};
}

/// Gathers the steps of a run, cut at the ticks.
class StepCutter {
 public:
  StepCutter(const std::map<std::uint64_t, double>& positions, std::uint64_t start_tick,
             double rate_hz)
      : positions_(positions), start_tick_(start_tick), rate_hz_(rate_hz) {}

  void Receive(drive::Cubic command, std::uint64_t subticks) {
    while (subticks > 0) {
      const std::uint64_t to_tick =
          motion::kSubticksPerTick - done_ % motion::kSubticksPerTick;
      const std::uint64_t step = std::min(subticks, to_tick);
      const double duration_s = motion::DurationSeconds(step, rate_hz_);
      done_ += step;
      subticks -= step;
      drive::DriveStep cut{command, duration_s, {}};
      if (done_ % motion::kSubticksPerTick == 0) {
        const auto known =
            positions_.find(start_tick_ + done_ / motion::kSubticksPerTick);
        if (known != positions_.end()) cut.position_u = known->second;
      }
      steps_.push_back(cut);
      command = Behind(command, duration_s);
    }
  }
  std::uint64_t ticks() const { return done_ / motion::kSubticksPerTick; }
  std::vector<drive::DriveStep> TakeSteps() { return std::move(steps_); }

 private:
  const std::map<std::uint64_t, double>& positions_;
  std::uint64_t start_tick_, done_ = 0;
  double rate_hz_;
  std::vector<drive::DriveStep> steps_;
};

}  // namespace

Result<RecordedAxis> ReadAxis(const recording::McapReader& reader, std::size_t axis,
                              std::uint64_t max_ticks) {
  const auto sessions = INTAGLIO_TRY(replayer::ReadCellSessions(reader));
  const auto [session, run] = INTAGLIO_TRY(LongestRun(sessions));
  const auto positions = INTAGLIO_TRY(PositionsOf(reader, axis, run->number));
  if (positions.empty()) {
    return Fail(ErrorCode::kMissing,
                "the recording has no positions of the motion; record PositionReport");
  }
  RecordedAxis record;
  record.run = run->number;
  record.rate_hz = session->job.job().laser().rate_hz();
  StepCutter cutter(positions, run->start_tick, record.rate_hz);
  const auto i_axis = static_cast<int>(axis);
  motion::KnotState from;
  // The stage rests before it begins, and latches from the first tick on.
  const auto number = static_cast<std::size_t>(run - session->messages.runs.data());
  from.position_mm[i_axis] = number < session->starts_mm.size()
                                 ? session->starts_mm[number][i_axis]
                                 : positions.begin()->second;
  for (std::size_t i = 0; i < run->duration_subticks.size(); ++i) {
    if (cutter.ticks() >= max_ticks) break;
    motion::Segment to;
    to.end_position_mm[i_axis] = run->columns[axis][i];
    to.end_velocity_mm_s[i_axis] = run->columns[axis + 3][i];
    to.duration_subticks = run->duration_subticks[i];
    const double duration_s =
        motion::DurationSeconds(to.duration_subticks, record.rate_hz);
    cutter.Receive({from.position_mm[i_axis], from.velocity_mm_s[i_axis],
                    motion::HermiteAcceleration(from, to, 0, duration_s)[i_axis],
                    motion::HermiteJerk(from, to, duration_s)[i_axis]},
                   to.duration_subticks);
    from = to.end();
  }
  record.tick_count = cutter.ticks();
  record.steps = cutter.TakeSteps();
  return record;
}

}  // namespace intaglio::cli
