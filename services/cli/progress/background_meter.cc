#include "services/cli/progress/background_meter.h"

#include <utility>

#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {
constexpr auto kPeriod = std::chrono::milliseconds(100);
}  // namespace

BackgroundMeter::BackgroundMeter(std::ostream& out, bool interactive,
                                 Clock::duration patience)
    : bar_(out, interactive),
      patience_(patience),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

BackgroundMeter::~BackgroundMeter() {
  thread_.request_stop();
  thread_.join();
  if (Clock::now() - began_ >= patience_) Draw();
  bar_.Finish();
}

void BackgroundMeter::Begin(const std::string& stage) {
  const std::lock_guard lock(mutex_);
  Enter(stage);
}

ProgressSink BackgroundMeter::Sink(std::string stage) {
  return [this, stage = std::move(stage)](std::uint64_t done, std::uint64_t total) {
    const std::lock_guard lock(mutex_);
    if (stage != stage_) Enter(stage);
    done_ = done;
    total_ = total;
    return true;
  };
}

void BackgroundMeter::Enter(const std::string& stage) {
  stage_ = stage;
  stage_began_ = Clock::now();
  done_ = total_ = 0;
}

void BackgroundMeter::Run(const std::stop_token& stop) {
  const auto never = [] { return false; };
  {
    std::unique_lock lock(mutex_);
    wake_.wait_until(lock, stop, began_ + patience_, never);
  }
  while (!stop.stop_requested()) {
    Draw();
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, stop, kPeriod, never);
  }
}

void BackgroundMeter::Draw() {
  const std::lock_guard lock(mutex_);
  if (stage_.empty()) return;
  const double elapsed_s =
      std::chrono::duration<double>(Clock::now() - stage_began_).count();
  bar_.ShowShare(stage_, done_, total_, elapsed_s,
                 total_ == 0 ? client::ShortDuration(elapsed_s) : std::string());
}

}  // namespace intaglio::cli
