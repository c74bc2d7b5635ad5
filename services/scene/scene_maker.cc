#include "services/scene/scene_maker.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "engrave/core/try.h"
#include "proto/foxglove.pb.h"
#include "services/scene/job_scene.h"
#include "services/scene/message_schema.h"

namespace intaglio::scene {
namespace {

using recording::MemberOf;

constexpr std::array<std::string_view, 4> kDrawn = {"PathBatch", "PulseEventBatch",
                                                    "MotionState", "Alarm"};
constexpr double kBetweenBlocksMm = 30;
// A recorder runs for months; a job has 20 bytes a point here.
constexpr std::size_t kKeptScenes = 16;

foxglove::Log::Level LevelOf(const std::string& severity) {
  if (severity == "ALARM_NOTICE") return foxglove::Log::INFO;
  return severity == "ALARM_WARNING" ? foxglove::Log::WARNING : foxglove::Log::ERROR;
}

}  // namespace

std::optional<FrozenJob> JobOf(const recording::Attachment& attachment) {
  FrozenJob job;
  if (!attachment.name.ends_with("/frozen_job.binpb") ||
      !job.ParseFromArray(attachment.content.data(),
                          static_cast<int>(attachment.content.size()))) {
    return std::nullopt;
  }
  return job;
}

bool SceneMaker::Draws(const std::string& topic) {
  return std::find(kDrawn.begin(), kDrawn.end(), topic) != kDrawn.end();
}

SceneMaker::SceneMaker(SceneSink sink) : sink_(std::move(sink)) {}
SceneMaker::~SceneMaker() = default;

void SceneMaker::AddJob(const FrozenJob& job) { jobs_[job.job_uid()] = job; }

JobScene& SceneMaker::SceneOf(const std::string& job_uid) {
  auto& scene = scenes_[job_uid];
  if (scene != nullptr) return *scene;
  const auto job = jobs_.find(job_uid);
  scene = std::make_unique<JobScene>(job_uid, job == jobs_.end() ? nullptr : &job->second,
                                     next_x_mm_, sink_);
  next_x_mm_ += scene->width_mm() + kBetweenBlocksMm;
  by_age_.push_back(job_uid);
  JobScene& made = *scene;
  if (by_age_.size() > kKeptScenes) ForgetOldest();
  return made;
}

void SceneMaker::ForgetOldest() {
  const std::string uid = by_age_.front();
  by_age_.pop_front();
  const auto scene = scenes_.find(uid);
  drawn_of_forgotten_ += scene->second->drawn_count();
  std::erase_if(at_cell_,
                [&](const auto& at) { return at.second == scene->second.get(); });
  scenes_.erase(scene);
  jobs_.erase(uid);
}

Status SceneMaker::AddAlarm(const recording::Value& alarm, std::uint64_t time_ns) {
  foxglove::Log log;
  SetTime(time_ns, *log.mutable_timestamp());
  log.set_level(LevelOf(MemberOf<std::string>(alarm, "severity")));
  log.set_message(MemberOf<std::string>(alarm, "message"));
  log.set_name(MemberOf<std::string>(alarm, "instance"));
  return sink_("alarms", log, time_ns);
}

Status SceneMaker::Add(const std::string& topic, const std::string& cell,
                       const recording::Value& message, std::uint64_t time_ns) {
  if (topic == "Alarm") return AddAlarm(message, time_ns);
  if (topic == "MotionState") {
    const auto scene = at_cell_.find(cell);
    return scene == at_cell_.end() ? Status() : scene->second->AddAxes(message, time_ns);
  }
  if (topic != "PathBatch" && topic != "PulseEventBatch") return {};
  JobScene& scene = SceneOf(MemberOf<std::string>(message, "job_uid"));
  if (topic == "PathBatch") return scene.AddPath(message, time_ns);
  at_cell_[cell] = &scene;
  return scene.AddPulses(message, time_ns);
}

Status SceneMaker::Finish() {
  for (const auto& [uid, scene] : scenes_) INTAGLIO_TRY(scene->Finish());
  return {};
}

void SceneMaker::BeginAnew() {
  for (const auto& [uid, scene] : scenes_) scene->BeginAnew();
}

std::uint64_t SceneMaker::drawn_count() const {
  std::uint64_t count = drawn_of_forgotten_;
  for (const auto& [uid, scene] : scenes_) count += scene->drawn_count();
  return count;
}

}  // namespace intaglio::scene
