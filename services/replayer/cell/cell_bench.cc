#include "services/replayer/cell/cell_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"
#include "services/replayer/found_service.h"

namespace intaglio::replayer {
namespace {

using namespace std::chrono_literals;

constexpr auto kCellTurn = 1ms;
// Messages have been received by then, and acted upon: a synchronizer turns every 5 ms.
constexpr auto kReceiveDelay = 50ms;
constexpr auto kPermissionPeriod = 20ms;
// Nothing moves any more.
constexpr auto kCellPatience = 10s;
constexpr auto kDrainTime = 100ms;

}  // namespace

struct CellBench::Performance {
  Performance(const CellSession& then, const std::string& frozen_job)
      : session(then), job(frozen_job), listener(then.task.id.job_uid) {}

  const CellSession& session;
  const std::string& job;
  CellListener listener;
  std::unique_ptr<StageInput> path;
  std::optional<PermissionMessage> permission;
  std::size_t next_event = 0;
  std::size_t begun = 0;           // present runs that correspond to one recorded run
  std::size_t consumed = 0;        // armed points of the newest one that have ended
  std::size_t fired = 0;           // of all
  bool over = false;               // what comes is of no interest
  Clock::time_point hold_until{};  // no tick passes
  Clock::time_point permission_due{};
  Clock::time_point moved_at = Clock::now();

  const CellRun* then() const {
    return begun == 0 || begun > session.messages.runs.size()
               ? nullptr
               : &session.messages.runs[begun - 1];
  }
  const CellRun* now() const {
    return listener.runs().empty() ? nullptr : &listener.runs().back();
  }
  const CellEvent* event() const {
    return next_event < session.events.size() ? &session.events[next_event] : nullptr;
  }
};

CellBench::CellBench(bus::Bus& bus, const recording::McapReader& reader,
                     const std::string& cell, SimulatedLaser& laser)
    : reader_(reader),
      laser_(laser),
      cell_(cell),
      tasks_(bus, bus::kEngraveTask),
      path_(bus, bus::kPathBatch),
      permissions_(bus, bus::kPermission, cell),
      stops_(bus, bus::kEmergencyStop, cell),
      health_(bus, bus::kServiceHealth),
      status_(bus, bus::kTaskStatus),
      pulses_(bus, bus::kPulseEventBatch, cell),
      book_(bus),
      stage_(bus, cell, kOwnName),
      wait_(bus) {
  wait_.Attach(status_);
  wait_.Attach(pulses_);
  wait_.Attach(stage_.reader());
  wait_.Attach(book_.reader());
}

// It is ready when its laser answers.
Result<std::string> CellBench::FindService(const KeepOn& keep_on) {
  const auto answer_and_keep_on = [&] {
    laser_.Turn(Clock::now().time_since_epoch(),
                [](std::size_t) { return std::optional<PulseEnd>(); });
    return keep_on();
  };
  auto found = INTAGLIO_TRY(
      AwaitService(health_, wait_, intaglio_ROLE_SYNCHRONIZER, answer_and_keep_on));
  instance_ = found.instance;
  return found.version;
}

Status CellBench::Give(const Performance& performance, bool revoked, bool take_up) {
  const RecordedTask& task = performance.session.task;
  const std::vector<char> job(performance.job.begin(), performance.job.end());
  intaglio_StageTask sample{};
  sample.worker = bus::Borrow(instance_);
  sample.epoch = task.epoch;
  sample.job_uid = bus::Borrow(task.id.job_uid);
  sample.attempt = task.id.attempt;
  sample.stage = intaglio_STAGE_ENGRAVE;
  sample.part_count = sample.input_part_count = 1;
  sample.revoked = revoked;
  sample.take_up = take_up;
  bus::Borrow(sample.frozen_job, job);
  const std::string consumer;
  sample.consumer = bus::Borrow(consumer);
  return tasks_.Write(sample);
}

Result<CellBench::Performed> CellBench::Perform(const CellSession& session,
                                                const std::string& frozen_job,
                                                const KeepOn& keep_on) {
  Performance performance(session, frozen_job);
  performance.path =
      std::make_unique<PathInput>(path_, reader_, session.task, session.task.id.job_uid);
  if (!session.starts_mm.empty()) stage_.MoveTo(session.starts_mm.front());
  stage_.CarryBlock(session.block_mm);
  INTAGLIO_TRY(Give(performance, false, false));
  Stillness stillness;
  while (!performance.listener.end()) {
    INTAGLIO_TRY(keep_on());
    INTAGLIO_TRY(Turn(performance));
    stillness = WhyNothingMore(performance);
    if (!stillness.why.empty()) break;
  }
  const bool ended = stillness.why.empty();
  Performed performed{performance.listener.Messages(), std::move(stillness),
                      performance.begun};
  INTAGLIO_TRY(Finish(performance, keep_on));
  if (ended) performed.messages = performance.listener.Messages();
  return performed;
}

Status CellBench::Turn(Performance& performance) {
  book_.Poll();
  INTAGLIO_TRY(performance.path->Advance(book_));
  TakeMessages(performance);
  DeliverDue(performance);
  KeepPermission(performance, false);
  const auto now = Clock::now();
  const std::uint64_t before = laser_.laser().tick();
  laser_.Turn(now.time_since_epoch(), [&](std::size_t armed) {
    auto end = EndOfPulse(performance, armed);
    if (end) ++performance.consumed;
    if (end && *end != PulseEnd::kNotInPosition) ++performance.fired;
    return end;
  });
  if (laser_.laser().tick() != before) performance.moved_at = now;
  if (stage_.Turn(now.time_since_epoch(), laser_.laser().tick(), performance.listener)) {
    performance.moved_at = now;
    BeginRun(performance);
  }
  (void)wait_.Wait(kCellTurn);
  return {};
}

void CellBench::TakeMessages(Performance& performance) {
  pulses_.TakeAll(
      [&](const intaglio_PulseEventBatch& sample, const bus::SampleOrigin& origin) {
        if (!origin.alive) return;
        performance.listener.Receive(MessageOf(sample),
                                     static_cast<std::uint64_t>(origin.source_ns));
        performance.moved_at = Clock::now();
      });
  status_.Take([&](const intaglio_TaskStatus& sample) {
    if (bus::View(sample.worker) == instance_ &&
        sample.attempt == performance.session.task.id.attempt)
      performance.listener.Receive(MessageOf(sample));
  });
}

/// A run that was given up before anything of it was decided corresponds to no recorded
/// run.
void CellBench::BeginRun(Performance& performance) {
  const auto& runs = performance.listener.runs();
  const bool given_up = performance.begun > 0 && performance.consumed == 0 &&
                        runs.size() > 1 && runs[runs.size() - 2].aborted;
  if (!given_up) ++performance.begun;
  performance.consumed = 0;
  const auto& starts = performance.session.starts_mm;
  if (performance.begun < starts.size()) stage_.MoveTo(starts[performance.begun]);
}

bool CellBench::AllAreReported(const Performance& performance) {
  return performance.listener.fired_count() >= performance.fired;
}

/// Every pulse of it has been reported, and the notice that the stage rests was received.
bool CellBench::RunIsOver(const Performance& performance) const {
  return stage_.at_rest() && AllAreReported(performance) &&
         Clock::now() > performance.moved_at + kReceiveDelay;
}

bool CellBench::IsDue(const Performance& performance) const {
  const CellEvent& event = *performance.event();
  if (event.run > performance.begun) return false;
  const CellRun* run = performance.then();
  if (event.run < performance.begun || run == nullptr) return true;
  // The event that broke the run off comes after all pulses of the recorded run have
  // ended: it was received a little later than it was sent.
  const std::size_t count = run->pulses.size();
  if (run->aborted) {
    return performance.consumed >= count &&
           (event.time_ns <= run->ended_ns || performance.now()->aborted);
  }
  // Asked at every pulse.
  const auto later = std::upper_bound(
      run->pulses.begin(), run->pulses.end(), event.tick,
      [](std::uint64_t tick, const RunPulse& pulse) { return tick < pulse.tick; });
  const auto ended_then = static_cast<std::size_t>(later - run->pulses.begin());
  if (run->open) return performance.consumed >= ended_then;
  return performance.consumed >= ended_then &&
         (ended_then < count || RunIsOver(performance));
}

void CellBench::DeliverDue(Performance& performance) {
  const auto now = Clock::now();
  if (performance.event() == nullptr || now < performance.hold_until ||
      !IsDue(performance))
    return;
  Deliver(performance, *performance.event());
  ++performance.next_event;
  performance.hold_until = now + kReceiveDelay;
  performance.moved_at = now;
}

void CellBench::Deliver(Performance& performance, const CellEvent& event) {
  if (const auto* permission = std::get_if<PermissionMessage>(&event.message)) {
    performance.permission = *permission;
    KeepPermission(performance, true);
  } else if (const auto* stop = std::get_if<StopMessage>(&event.message)) {
    intaglio_EmergencyStop sample{};
    sample.cell = bus::Borrow(cell_);
    sample.pressed = stop->pressed;
    sample.source = bus::Borrow(stop->source);
    sample.number = stop->number;
    const std::string operator_name = kOwnName, reason = "as recorded";
    sample.operator_name = bus::Borrow(operator_name);
    sample.reason = bus::Borrow(reason);
    std::vector<intaglio_StopPress> released;
    for (const RecordedPress& press : stop->released)
      released.push_back({bus::Borrow(press.source), press.number});
    bus::Borrow(sample.released, released);
    (void)stops_.Write(sample);
  } else if (const auto* interlock = std::get_if<InterlockMessage>(&event.message)) {
    SetInterlocks(*interlock);
  } else if (const auto* fault = std::get_if<StageFaultMessage>(&event.message)) {
    stage_.Fail(fault->fault, fault->message);
  } else if (const auto* revoke = std::get_if<RevokeMessage>(&event.message)) {
    (void)Give(performance, true, revoke->take_up);
  }
}

// Stop and safe state stay until the synchronizer resets them, as it did then.
void CellBench::SetInterlocks(const InterlockMessage& message) {
  virtual_engraver::Laser& laser = laser_.laser();
  laser.SetKey(message.key_on);
  laser.SetDoor(message.door_closed);
  if (!message.stop_released) {
    laser.SetStopButton(true);
    laser.SetStopButton(false);
  }
  if (message.safe_state) laser.EnterSafeState();
}

/// None of the recorded events broke the run off: the cause was a message that came too
/// late, or a line that fell silent for a moment. In this case the permission is
/// withdrawn instead: for a late one the simulated laser would wait.
bool CellBench::BreaksOff(const Performance& performance) const {
  const CellRun* run = performance.then();
  const CellEvent* event = performance.event();
  return run != nullptr && run->aborted && !performance.now()->aborted &&
         performance.consumed >= run->pulses.size() &&
         (event == nullptr || event->run > performance.begun ||
          event->time_ns > run->ended_ns) &&
         Clock::now() > performance.hold_until + kReceiveDelay;
}

/// The next run does not begin before everything that came before it in the recording has
/// been sent.
bool CellBench::HoldsBack(const Performance& performance) const {
  const bool between_runs = performance.begun == 0 || performance.now()->aborted;
  return between_runs && performance.event() != nullptr && IsDue(performance);
}

void CellBench::KeepPermission(Performance& performance, bool at_once) {
  const auto now = Clock::now();
  if (!performance.permission || (!at_once && now < performance.permission_due)) return;
  performance.permission_due = now + kPermissionPeriod;
  const PermissionMessage& message = *performance.permission;
  intaglio_Permission sample{};
  sample.cell = bus::Borrow(cell_);
  sample.job_uid = bus::Borrow(performance.session.task.id.job_uid);
  sample.epoch = message.epoch;
  sample.granted = message.granted && !HoldsBack(performance) && !BreaksOff(performance);
  const std::string operator_name = kOwnName;
  sample.operator_name = bus::Borrow(operator_name);
  sample.number = ++permission_number_;
  sample.speed_percent = message.speed_percent;
  sample.grant = message.grant;
  sample.first_point = message.first_point;
  sample.fire_uncertain = message.fire_uncertain;
  sample.renewal = message.renewal;
  (void)permissions_.Write(sample);
}

std::optional<PulseEnd> CellBench::EndOfPulse(Performance& performance,
                                              std::size_t armed) const {
  // What is still armed is taken back.
  if (performance.over) return PulseEnd::kNotInPosition;
  if (Clock::now() < performance.hold_until) return std::nullopt;
  if (performance.event() != nullptr && IsDue(performance)) return std::nullopt;
  const CellRun* run = performance.then();
  // For a run that is not in the recording, or one that goes on, no other result is
  // known.
  if (run == nullptr) return PulseEnd::kSeen;
  const std::size_t determined = run->pulses.size(), at = performance.consumed;
  if (at >= determined)
    return run->undisturbed() ? std::optional(PulseEnd::kSeen) : std::nullopt;
  const RunPulse& pulse = run->pulses[at];
  if (pulse.fired()) return pulse.missed() ? PulseEnd::kUnseen : PulseEnd::kSeen;
  // It ends the run: what had been armed by then has to be armed.
  if (armed < determined - at) return std::nullopt;
  return PulseEnd::kNotInPosition;
}

CellBench::Stillness CellBench::WhyNothingMore(const Performance& performance) const {
  const auto now = Clock::now();
  if (performance.listener.end() || now < performance.hold_until + kReceiveDelay)
    return {};
  const auto still = now - performance.moved_at;
  const CellRun* run = performance.then();
  const bool all_sent = performance.event() == nullptr &&
                        performance.begun >= performance.session.messages.runs.size() &&
                        !performance.session.messages.end;
  const bool all_ended = run == nullptr || performance.consumed >= run->pulses.size();
  const bool is_over = RunIsOver(performance) ||
                       (run != nullptr && run->open && AllAreReported(performance));
  if (all_sent && all_ended && is_over && still > 20 * kReceiveDelay)
    return {performance.session.ends_early.empty() ? "the recording ends there"
                                                   : performance.session.ends_early,
            true};
  if (still < kCellPatience) return {};
  if (run != nullptr && !run->undisturbed() && all_ended)
    return {fmt::format("the cause of the end of run {} is not in the recording",
                        run->number),
            true};
  const std::string& message = performance.listener.message();
  return {"the synchronizer does not continue" +
              (message.empty() ? std::string() : " (" + message + ")"),
          false};
}

/// The last samples; the next task finds a synchronizer without one.
Status CellBench::Finish(Performance& performance, const KeepOn& keep_on) {
  performance.next_event = performance.session.events.size();
  const bool ended = performance.listener.end().has_value();
  performance.over = true;
  if (!ended) {
    if (auto given = Give(performance, true, false); !given) return given;
  }
  const auto until = Clock::now() + (ended ? kDrainTime : kCellPatience);
  auto end = until;
  while (Clock::now() < end) {
    INTAGLIO_TRY(keep_on());
    INTAGLIO_TRY(Turn(performance));
    if (!ended && performance.listener.end() && end == until)
      end = std::min(until, Clock::now() + kDrainTime);
  }
  return {};
}

}  // namespace intaglio::replayer
