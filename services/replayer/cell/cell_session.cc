#include "services/replayer/cell/cell_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "engrave/core/try.h"
#include "services/platform/bus/topics.h"
#include "services/replayer/recorded_members.h"

namespace intaglio::replayer {
namespace {

using recording::Value;

/// sink(value, publish_time_ns) of every sample of a topic within the times.
template <typename Sink>
Status ForEach(const recording::McapReader& reader, const char* topic, Sink&& sink) {
  RecordedValues values(reader, topic);
  for (;;) {
    const auto value = INTAGLIO_TRY(values.Next());
    if (!value) return {};
    if (!sink(*value, values.publish_time_ns())) {
      return Fail(
          ErrorCode::kUnsupported,
          fmt::format("{}: the recording has a version whose samples are unknown", topic),
          topic);
    }
  }
}

struct Rest {
  std::uint64_t at_ns;
  Vec3 at_mm;
  std::optional<Vec2> block_mm;
};

/// None also in recordings from before there were such stages.
std::optional<Vec2> CarriedBlockIn(const Value& value) {
  const Value* const has = value.Find("has_block_stage");
  if (has == nullptr || has->As<bool>() == nullptr || !*has->As<bool>()) return {};
  Vec2 block_mm = Vec2::Zero();
  Members members(value);
  members.Get("block_x_mm", block_mm.x());
  members.Get("block_y_mm", block_mm.y());
  return block_mm;
}

/// Reads one task: from its being given to the next task of the cell.
class SessionReader {
 public:
  SessionReader(const recording::McapReader& reader, CellSession& session,
                std::uint64_t to_ns)
      : reader_(reader),
        session_(session),
        from_ns_(session.task.publish_time_ns),
        to_ns_(to_ns),
        cell_(session.job.machine().name()) {}

  Status Read();

 private:
  bool Within(std::uint64_t at_ns) const { return at_ns >= from_ns_ && at_ns < to_ns_; }
  /// Whether it is of the cell; nothing for a value without the member.
  std::optional<bool> Ours(const Value& value) const;
  Status ReadMessages();
  Status ReadPermission();
  Status ReadInterlocks();
  Status ReadMotion();
  Status ReadTicks();
  Status ReadTaught();
  void Place();
  void EndBefore(std::uint32_t run, const std::string& why);
  void EndBeforeGap(std::uint32_t run, const std::string& why);
  void EndBeforeTheUnknown();
  void PlaceStarts(const std::vector<Rest>& rests);
  void NoteMissingTopic();
  template <typename Message>
  void Add(std::uint64_t at_ns, Message message) {
    session_.events.push_back({at_ns, 0, 0, std::move(message)});
  }

  const recording::McapReader& reader_;
  CellSession& session_;
  std::uint64_t from_ns_, to_ns_;
  std::string cell_;
  bool has_motion_ = false, has_ticks_ = false;
};

std::optional<bool> SessionReader::Ours(const Value& value) const {
  const Value* cell = value.Find("cell");
  const auto* name = cell == nullptr ? nullptr : cell->As<std::string>();
  if (name == nullptr) return std::nullopt;
  return *name == cell_;
}

Status SessionReader::ReadMessages() {
  CellListener listener(session_.task.id.job_uid);
  auto read = ForEach(reader_, bus::kMotionSegmentBatch.name,
                      [&](const Value& value, std::uint64_t at_ns) {
                        const auto messages = ReadSegments(value);
                        if (messages && Within(at_ns))
                          (void)listener.Receive(*messages, at_ns);
                        return messages.has_value();
                      });
  if (!read) return read;
  read = ForEach(reader_, bus::kPulseEventBatch.name,
                 [&](const Value& value, std::uint64_t at_ns) {
                   const auto messages = ReadPulses(value);
                   if (messages && Within(at_ns)) listener.Receive(*messages, at_ns);
                   return messages.has_value();
                 });
  if (!read) return read;
  read = ForEach(
      reader_, bus::kTaskStatus.name, [&](const Value& value, std::uint64_t at_ns) {
        const auto messages = ReadStatus(value);
        if (messages && Within(at_ns) && messages->attempt == session_.task.id.attempt)
          listener.Receive(*messages);
        return messages.has_value();
      });
  session_.messages = listener.Messages();
  return read;
}

Status SessionReader::ReadPermission() {
  std::optional<PermissionMessage> newest;
  auto read = ForEach(reader_, bus::kPermission.name,
                      [&](const Value& value, std::uint64_t at_ns) {
                        PermissionMessage message;
                        std::string job_uid;
                        Members members(value);
                        members.Get("job_uid", job_uid);
                        members.Get("epoch", message.epoch);
                        members.Get("granted", message.granted);
                        members.Get("speed_percent", message.speed_percent);
                        members.Get("grant", message.grant);
                        members.Get("first_point", message.first_point);
                        members.Get("renewal", message.renewal);
                        // Older recordings have none.
                        if (value.Find("fire_uncertain") != nullptr)
                          members.Get("fire_uncertain", message.fire_uncertain);
                        if (!members.good()) return false;
                        if (job_uid != session_.task.id.job_uid || at_ns >= to_ns_)
                          return true;
                        if (newest != message) Add(at_ns, message);
                        newest = message;
                        return true;
                      });
  if (!read) return read;
  RecordedStops stops(cell_);
  return ForEach(reader_, bus::kEmergencyStop.name,
                 [&](const Value& value, std::uint64_t at_ns) {
                   auto sample = stops.Read(value);
                   if (sample && sample->ours && Within(at_ns))
                     Add(at_ns, std::move(sample->stop));
                   return sample.has_value();
                 });
}

Status SessionReader::ReadInterlocks() {
  InterlockMessage newest;
  return ForEach(reader_, bus::kInterlock.name,
                 [&](const Value& value, std::uint64_t at_ns) {
                   InterlockMessage message;
                   bool up = false;
                   Members members(value);
                   members.Get("key_on", message.key_on);
                   members.Get("door_closed", message.door_closed);
                   members.Get("emergency_stop_released", message.stop_released);
                   members.Get("safe_state", message.safe_state);
                   members.Get("laser_link_up", up);
                   const auto ours = Ours(value);
                   if (!members.good() || !ours) return false;
                   if (!*ours || !Within(at_ns)) return true;
                   // The state of a silent line is not known. A machine that closed its
                   // shutters because of the silence reports that when the line is back.
                   if (!up) return true;
                   if (message != newest) Add(at_ns, newest = message);
                   return true;
                 });
}

/// The stage rested after the run before, and its place is what the next one begins at.
void SessionReader::PlaceStarts(const std::vector<Rest>& rests) {
  std::uint64_t from_ns = 0;
  for (const CellRun& run : session_.messages.runs) {
    const auto later = std::find_if(rests.begin(), rests.end(), [&](const Rest& rest) {
      return rest.at_ns > run.begun_ns;
    });
    if (later == rests.begin() || std::prev(later)->at_ns < from_ns) {
      EndBeforeGap(run.number,
                   fmt::format("the stage's place before run {} is missing in "
                               "the recording",
                               run.number));
      return;
    }
    if (session_.starts_mm.empty()) session_.block_mm = std::prev(later)->block_mm;
    session_.starts_mm.push_back(std::prev(later)->at_mm);
    from_ns = run.begun_ns;
  }
}

Status SessionReader::ReadMotion() {
  std::vector<Rest> rests;
  StageFaultMessage newest{"MOTION_OK", ""};
  auto read = ForEach(reader_, bus::kMotionState.name,
                      [&](const Value& value, std::uint64_t at_ns) {
                        Vec3 at = Vec3::Zero();
                        bool at_rest = false;
                        StageFaultMessage message;
                        Members members(value);
                        members.Get("x_mm", at.x());
                        members.Get("y_mm", at.y());
                        members.Get("z_mm", at.z());
                        members.Get("at_rest", at_rest);
                        members.Get("fault", message.fault);
                        members.Get("message", message.message);
                        const auto ours = Ours(value);
                        if (!members.good() || !ours) return false;
                        if (!*ours || at_ns >= to_ns_) return true;
                        has_motion_ = true;
                        if (at_rest) rests.push_back({at_ns, at, CarriedBlockIn(value)});
                        if (at_ns >= from_ns_ && message != newest)
                          Add(at_ns, newest = message);
                        return true;
                      });
  if (has_motion_) PlaceStarts(rests);
  return read;
}

/// Recordings from before machines were moved by hand have none.
Status SessionReader::ReadTaught() {
  const auto& runs = session_.messages.runs;
  const std::uint64_t until_ns = runs.empty() ? to_ns_ : runs.front().begun_ns;
  return ForEach(
      reader_, bus::kManualState.name, [&](const Value& value, std::uint64_t at_ns) {
        const Value* number = value.Find("taught_number");
        const auto* taught = number == nullptr ? nullptr : number->As<std::uint64_t>();
        if (taught != nullptr && at_ns < until_ns && Ours(value) == true)
          session_.taught_number = static_cast<std::uint32_t>(*taught);
        return true;
      });
}

/// Which run and tick each event belongs to.
Status SessionReader::ReadTicks() {
  auto event = session_.events.begin();
  std::uint64_t newest = 0;
  const auto read =
      ForEach(reader_, bus::kLampSync.name, [&](const Value& value, std::uint64_t at_ns) {
        std::uint64_t tick = 0;
        Members members(value);
        members.Get("tick", tick);
        const auto ours = Ours(value);
        if (!members.good() || !ours) return false;
        if (!*ours) return true;
        has_ticks_ = true;
        for (; event != session_.events.end() && event->time_ns < at_ns; ++event)
          event->tick = newest;
        newest = tick;
        return true;
      });
  for (; event != session_.events.end(); ++event) event->tick = newest;
  return read;
}

void SessionReader::Place() {
  for (CellEvent& event : session_.events) {
    const auto& runs = session_.messages.runs;
    event.run = static_cast<std::size_t>(
        std::count_if(runs.begin(), runs.end(),
                      [&](const CellRun& run) { return run.begun_ns <= event.time_ns; }));
  }
  std::uint32_t speed_percent = 100;
  for (const CellEvent& event : session_.events) {
    const auto* message = std::get_if<PermissionMessage>(&event.message);
    if (message == nullptr || message->speed_percent == speed_percent) continue;
    speed_percent = message->speed_percent;
    if (event.run > 0) session_.messages.runs[event.run - 1].respeeded = true;
  }
}

void SessionReader::EndBefore(std::uint32_t run, const std::string& why) {
  if (run == 0) return;
  session_.ends_early = why;
  std::erase_if(session_.messages.runs,
                [run](const CellRun& one) { return one.number >= run; });
  session_.messages.end.reset();
}

/// What came before is known; the run before may have gone on.
void SessionReader::EndBeforeGap(std::uint32_t run, const std::string& why) {
  EndBefore(run, why);
  auto& runs = session_.messages.runs;
  if (!runs.empty()) runs.back().open = !runs.back().aborted;
}

/// A pulse of unknown result comes of another power-up of the laser.
void SessionReader::EndBeforeTheUnknown() {
  const bool ended = session_.messages.end.has_value();
  const std::uint32_t lost = session_.messages.uncertain_run;
  const std::uint32_t incomplete = session_.messages.incomplete_run;
  EndBefore(lost, fmt::format("in run {} the outcome of some pulses was unknown", lost));
  if (incomplete != 0 && (lost == 0 || incomplete < lost)) {
    EndBeforeGap(
        incomplete,
        fmt::format("messages of run {} are missing in the recording", incomplete));
  } else if (!ended && lost == 0) {
    EndBeforeGap(std::numeric_limits<std::uint32_t>::max(), "the recording ends there");
  }
}

/// A machine that moved had them all, and a job that was made had pulses. A recording may
/// leave topics out, or be cut to some.
void SessionReader::NoteMissingTopic() {
  const CellMessages& messages = session_.messages;
  const bool done = messages.end && messages.end->state == "TASK_DONE";
  if (messages.runs.empty() && !done) return;
  const bool fired = std::any_of(messages.runs.begin(), messages.runs.end(),
                                 [](const CellRun& run) { return !run.pulses.empty(); });
  const bool permitted = std::any_of(
      session_.events.begin(), session_.events.end(), [](const CellEvent& event) {
        return std::holds_alternative<PermissionMessage>(event.message);
      });
  const bool has_pulses =
      fired || (!done && messages.runs.size() + messages.given_up_count < 2);
  for (const auto& [there, topic] :
       {std::pair(!messages.runs.empty(), bus::kMotionSegmentBatch.name),
        std::pair(has_pulses, bus::kPulseEventBatch.name),
        std::pair(permitted, bus::kPermission.name),
        std::pair(has_motion_, bus::kMotionState.name),
        std::pair(has_ticks_, bus::kLampSync.name)}) {
    if (!there && session_.lacks.empty()) session_.lacks = topic;
  }
}

Status SessionReader::Read() {
  INTAGLIO_TRY(ReadMessages());
  INTAGLIO_TRY(ReadInterlocks());
  INTAGLIO_TRY(ReadTaught());
  EndBeforeTheUnknown();
  INTAGLIO_TRY(ReadPermission());
  INTAGLIO_TRY(ReadMotion());
  std::stable_sort(
      session_.events.begin(), session_.events.end(),
      [](const CellEvent& a, const CellEvent& b) { return a.time_ns < b.time_ns; });
  Place();
  INTAGLIO_TRY(ReadTicks());
  NoteMissingTopic();
  return {};
}

}  // namespace

Result<std::vector<CellSession>> ReadCellSessions(const recording::McapReader& reader) {
  std::vector<CellSession> sessions;
  std::vector<std::pair<std::uint64_t, RecordedTask>> revoked;
  INTAGLIO_TRY(ForEach(
      reader, bus::kEngraveTask.name, [&](const Value& value, std::uint64_t at_ns) {
        auto task = ReadTask(value);
        if (!task) return false;
        task->publish_time_ns = at_ns;
        CellSession session;
        if (task->revoked) {
          revoked.emplace_back(at_ns, std::move(*task));
          return true;
        }
        const bool again =
            std::any_of(sessions.begin(), sessions.end(), [&](const CellSession& other) {
              return other.task.id == task->id && other.task.take_up == task->take_up;
            });
        if (again) return true;
        if (!session.job.ParseFromString(task->frozen_job)) return false;
        session.task = std::move(*task);
        sessions.push_back(std::move(session));
        return true;
      }));
  for (auto session = sessions.begin(); session != sessions.end(); ++session) {
    const auto next =
        std::find_if(std::next(session), sessions.end(), [&](const CellSession& other) {
          return other.job.machine().name() == session->job.machine().name();
        });
    const std::uint64_t to_ns = next == sessions.end()
                                    ? std::numeric_limits<std::uint64_t>::max()
                                    : next->task.publish_time_ns;
    for (const auto& [at_ns, task] : revoked) {
      if (task.id == session->task.id && at_ns >= session->task.publish_time_ns)
        session->events.push_back({at_ns, 0, 0, RevokeMessage{task.take_up}});
    }
    if (auto read = SessionReader(reader, *session, to_ns).Read(); !read)
      return tl::unexpected(read.error());
  }
  std::erase_if(sessions, [](const CellSession& session) {
    return session.messages.runs.empty() && session.messages.states.empty();
  });
  return sessions;
}

}  // namespace intaglio::replayer
