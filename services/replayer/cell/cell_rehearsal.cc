#include "services/replayer/cell/cell_rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/platform/bus/bus.h"
#include "services/replayer/cause.h"
#include "services/replayer/cell/cell_bench.h"
#include "services/replayer/cell/cell_comparison.h"
#include "services/replayer/option_differences.h"

namespace intaglio::replayer {
namespace {

// On a busy host a line may fall silent, or a permission come too late, now as then.
constexpr int kTries = 3;

/// The first field in which two profiles differ: "machine.origin_x_mm: 1 and 2"; empty:
/// none.
std::string OtherProfile(const MachineSpec& first, const MachineSpec& second) {
  FrozenJob a, b;
  *a.mutable_machine() = first;
  *b.mutable_machine() = second;
  const auto differences = OptionDifferences(a, b);
  if (differences.empty()) return "";
  const OptionDifference& one = differences.front();
  return fmt::format("{} is {} and {}", one.field(),
                     one.then().empty() ? "not there" : one.then(),
                     one.now().empty() ? "not there" : one.now());
}

/// The synchronizer gave the task back without a motion: by what its machine was or had
/// then, which is not in the recording.
bool WasRefused(const CellSession& session) {
  const CellMessages& then = session.messages;
  return then.end && then.end->state == "TASK_FAILED" && then.runs.empty() &&
         then.given_up_count == 0;
}

class CellRehearsal {
 public:
  CellRehearsal(bus::Bus& bus, const recording::McapReader& reader,
                const CellRehearsalOptions& options, const KeepOn& keep_on)
      : bus_(bus), reader_(reader), options_(options), keep_on_(keep_on) {}

  Result<ReplayComparison> Run();

 private:
  struct Different {
    const CellSession* session;
    FrozenJob job;
    CellMessages now;
  };
  Status ReadRecording();
  bool HasInput(const CellSession& session);
  void ReportIncomparable(const CellSession& session, const std::string& why);
  Result<FrozenJob> FreezeAgain(const CellSession& session);
  Result<CellBench::Performed> Perform(const CellSession& session, FrozenJob job);
  Result<std::optional<SampleDifference>> Compare(CellSession& session,
                                                  const FrozenJob& job,
                                                  CellMessages& now);
  Status CompareAll();
  Status FindCause();

  bus::Bus& bus_;
  const recording::McapReader& reader_;
  const CellRehearsalOptions& options_;
  const KeepOn& keep_on_;
  MachineSpec machine_;  // with which the synchronizer was started
  std::string cell_;
  std::vector<CellSession> sessions_;
  std::map<StreamId, StreamExtent> paths_;
  std::unique_ptr<SimulatedLaser> laser_;
  std::unique_ptr<CellBench> bench_;
  std::optional<Different> different_;
  int folder_count_ = 0;
  bool all_performed_ = true;
  ReplayComparison result_;
};

Status CellRehearsal::ReadRecording() {
  auto machine = INTAGLIO_TRY(MachineOf(reader_));
  machine_ = std::move(machine);
  cell_ = machine_.name();
  auto sessions = INTAGLIO_TRY(ReadCellSessions(reader_));
  sessions_ = std::move(sessions);
  auto paths = INTAGLIO_TRY(ExtentsOf(reader_, bus::kPathBatch.name));
  paths_ = std::move(paths);
  auto laser = INTAGLIO_TRY(SimulatedLaser::Make(options_.laser_line, machine_));
  laser_ = std::move(laser);
  return {};
}

void CellRehearsal::ReportIncomparable(const CellSession& session,
                                       const std::string& why) {
  all_performed_ = false;
  result_.add_input(fmt::format("job {}: {}", session.task.id.job_uid, why));
}

bool CellRehearsal::HasInput(const CellSession& session) {
  const StreamId& id = session.task.id;
  const auto lacks = [&](const std::string& what) {
    ReportIncomparable(session, what);
    return false;
  };
  if (session.job.machine().name() != cell_)
    return lacks(fmt::format("it was engraved by {}, this is {}",
                             session.job.machine().name(), cell_));
  if (!session.lacks.empty())
    return lacks(
        fmt::format("not comparable: the recording has no {} of it", session.lacks));
  const std::uint32_t frozen = session.job.machine().taught().number();
  if (const std::uint32_t first = machine_.taught().number(); first != frozen)
    return lacks(
        fmt::format("not comparable: zeros, positions or limits were taught between the "
                    "jobs: it has version {} of them, the job that is compared first has "
                    "version {}; cut the recording (intaglio recording cut --from) to "
                    "compare it alone",
                    frozen, first));
  if (const auto other = OtherProfile(machine_, session.job.machine()); !other.empty())
    return lacks(
        fmt::format("not comparable: it was engraved with another profile than the job "
                    "that is compared first: {}",
                    other));
  if (session.taught_number && *session.taught_number != frozen)
    return lacks(
        fmt::format("not comparable: its machine had version {} of what was taught, the "
                    "job has version {}: the zeros and limits that it was made with are "
                    "not in the recording",
                    *session.taught_number, frozen));
  if (session.task.take_up)
    return lacks(
        "it was resumed in the middle; the contents of its folder are not recorded");
  const auto path = paths_.find(id);
  if (path == paths_.end() || !path->second.whole)
    return lacks("its path is not complete in the recording");
  return true;
}

Result<FrozenJob> CellRehearsal::FreezeAgain(const CellSession& session) {
  FrozenJob now = session.job;
  result_.set_version_then(now.software_version());
  if (options_.change) {
    INTAGLIO_TRY(options_.change(now));
    if (result_.options().empty()) {
      for (OptionDifference& difference : OptionDifferences(session.job, now))
        *result_.add_options() = std::move(difference);
    }
  }
  return now;
}

/// In a folder of its own; once more when this host broke a run off that went on then.
Result<CellBench::Performed> CellRehearsal::Perform(const CellSession& session,
                                                    FrozenJob job) {
  for (int tries = 1;; ++tries) {
    job.set_result_directory(
        (options_.results / fmt::format("job-{}", ++folder_count_)).string());
    auto performed = bench_->Perform(session, job.SerializeAsString(), keep_on_);
    if (!performed || tries == kTries) return performed;
    const CellBench::Stillness& stillness = performed->stillness;
    if ((stillness.why.empty() || stillness.by_recording) &&
        performed->messages.broken_count() <= session.messages.broken_count())
      return performed;
  }
}

Result<std::optional<SampleDifference>> CellRehearsal::Compare(CellSession& session,
                                                               const FrozenJob& job,
                                                               CellMessages& now) {
  auto performed = INTAGLIO_TRY(Perform(session, job));
  now = std::move(performed.messages);
  TaskComparison& counts = *result_.add_tasks();
  counts.set_job_uid(session.task.id.job_uid);
  counts.set_attempt(session.task.id.attempt);
  const CellBench::Stillness& stillness = performed.stillness;
  if (!stillness.why.empty() && stillness.by_recording) {
    counts.set_recorded_in_part(true);
    counts.set_part_reason(stillness.why);
    CellMessages& then = session.messages;
    if (then.runs.size() > performed.run_count) then.runs.resize(performed.run_count);
    then.end.reset();
  }
  // A synchronizer that does nothing more has made no other result: this host may have no
  // time for it, whatever its code is.
  const bool hangs = !stillness.why.empty() && !stillness.by_recording;
  if (hangs) {
    KeepRunsBefore(performed.run_count - std::min<std::size_t>(1, performed.run_count),
                   session.messages, now);
  }
  auto found = CompareCells(session.messages, now, counts);
  if (!found && hangs) {
    ReportIncomparable(
        session,
        fmt::format("not comparable: {} in {}; repeat it on a computer with time to "
                    "spare, and look into the synchronizer's log if it is so again",
                    stillness.why, Counted(kTries, "try", "tries")));
  }
  if (counts.recorded_in_part() && counts.run_count() == 0) {
    ReportIncomparable(session, counts.part_reason());
  }
  if (found && WasRefused(session)) {
    ReportIncomparable(session, "not comparable: it was refused before anything moved (" +
                                    session.messages.end->message +
                                    "); what it was compared with is not recorded");
    return std::optional<SampleDifference>();
  }
  if (found) {
    found->set_job_uid(session.task.id.job_uid);
    found->set_attempt(session.task.id.attempt);
  }
  return found;
}

Status CellRehearsal::CompareAll() {
  for (CellSession& session : sessions_) {
    if (!HasInput(session)) continue;
    auto job = INTAGLIO_TRY(FreezeAgain(session));
    CellMessages now;
    auto found = INTAGLIO_TRY(Compare(session, job, now));
    if (!found || different_) continue;
    *result_.mutable_first() = *found;
    different_ = {&session, std::move(job), std::move(now)};
  }
  return {};
}

Status CellRehearsal::FindCause() {
  return NameCause(result_, [this]() -> Result<bool> {
    const auto again = INTAGLIO_TRY(Perform(*different_->session, different_->job));
    TaskComparison ignored;
    return CompareCells(different_->now, again.messages, ignored).has_value();
  });
}

Result<ReplayComparison> CellRehearsal::Run() {
  result_.set_service("synchronizer");
  INTAGLIO_TRY(ReadRecording());
  bench_ = std::make_unique<CellBench>(bus_, reader_, cell_, *laser_);
  const auto version = INTAGLIO_TRY(bench_->FindService(keep_on_));
  result_.set_version_now(version);
  INTAGLIO_TRY(CompareAll());
  result_.set_identical(!different_ && all_performed_);
  if (different_) {
    if (auto found = FindCause(); !found) return tl::unexpected(found.error());
  } else if (!all_performed_) {
    result_.set_cause("input");
    result_.set_explanation(result_.input(result_.input_size() - 1));
  }
  return std::move(result_);
}

}  // namespace

Result<MachineSpec> MachineOf(const recording::McapReader& reader) {
  const auto sessions = INTAGLIO_TRY(ReadCellSessions(reader));
  // The profile of a job that was refused may be another than the machine had.
  const auto moved = std::find_if(
      sessions.begin(), sessions.end(),
      [](const CellSession& session) { return !session.messages.runs.empty(); });
  if (moved != sessions.end()) return moved->job.machine();
  if (!sessions.empty()) return sessions.front().job.machine();
  return Fail(
      ErrorCode::kMissing,
      fmt::format("the recording has no {} whose job is known: nothing to compare",
                  bus::kEngraveTask.name));
}

Result<ReplayComparison> RehearseCell(bus::Bus& bus, const recording::McapReader& reader,
                                      const CellRehearsalOptions& options,
                                      const KeepOn& keep_on) {
  return CellRehearsal(bus, reader, options, keep_on).Run();
}

}  // namespace intaglio::replayer
