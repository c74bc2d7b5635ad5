#include "services/console/submit/about_times.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "proto/preview.pb.h"
#include "services/client/shop/work_left.h"
#include "services/console/submit/program_run.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

/// A larger job has no time before its plan.
constexpr std::chrono::seconds kPreviewTime{120};
constexpr std::size_t kMaxWaiting = 256;

}  // namespace

AboutTimes::AboutTimes(fs::path database, std::string materials)
    : database_(std::move(database)), materials_(std::move(materials)) {
  if (database_.empty()) return;
  std::error_code error;
  scratch_ = fs::temp_directory_path(error) / fmt::format("intaglio-about-{}", getpid());
  runs_.emplace(kMaxWaiting);
}

AboutTimes::~AboutTimes() {
  runs_.reset();
  std::error_code ignored;
  if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
}

void AboutTimes::Follow(const std::map<std::string, client::JobView>& jobs,
                        Clock::time_point now) {
  if (!runs_) return;
  std::vector<std::string> wanted;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const auto& known) {
      const auto job = jobs.find(known.first);
      return job == jobs.end() || job->second.ended();
    });
    for (const auto& [uid, job] : jobs) {
      if (job.ended()) continue;
      Asked& asked = jobs_.try_emplace(uid, Asked{.since = now}).first->second;
      asked.is_planned = client::EngravingSeconds(job) > 0;
      if (asked.is_planned || asked.is_asked || now - asked.since < kPatience) continue;
      asked.is_asked = true;
      wanted.push_back(uid);
    }
  }
  for (const std::string& uid : wanted) (void)runs_->Add([this, uid] { Ask(uid); });
}

void AboutTimes::Ask(const std::string& uid) {
  {
    // It may have been planned, or ended, while it waited for this.
    const std::lock_guard lock(mutex_);
    const auto known = jobs_.find(uid);
    if (known == jobs_.end() || known->second.is_planned) return;
  }
  std::error_code error;
  fs::create_directories(scratch_, error);
  std::vector<std::string> words = {"preview",
                                    uid,
                                    "--database",
                                    database_.string(),
                                    "--json",
                                    "--out",
                                    (scratch_ / "preview").string()};
  if (!materials_.empty()) words.insert(words.end(), {"--materials", materials_});
  const auto end = RunIntaglio(std::move(words), scratch_, kPreviewTime);
  JobPreview preview;
  google::protobuf::util::JsonParseOptions lenient;
  lenient.ignore_unknown_fields = true;
  // A job that has no preview has no time before its plan.
  if (!end || end->json.empty() ||
      !google::protobuf::util::JsonStringToMessage(end->json.front(), &preview, lenient)
           .ok())
    return;
  const std::lock_guard lock(mutex_);
  if (const auto known = jobs_.find(uid); known != jobs_.end())
    known->second.time_s = preview.time().machining_time_s();
}

std::vector<AboutTime> AboutTimes::Known() const {
  std::vector<AboutTime> times;
  const std::lock_guard lock(mutex_);
  for (const auto& [uid, asked] : jobs_) {
    if (asked.is_planned || asked.time_s <= 0) continue;
    AboutTime& time = times.emplace_back();
    time.set_uid(uid);
    time.set_time_s(asked.time_s);
  }
  return times;
}

}  // namespace intaglio::console
