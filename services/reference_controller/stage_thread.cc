#include "services/reference_controller/stage_thread.h"

#include <utility>

#include "services/reference_controller/exact_time.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

// No braking takes longer.
constexpr nanoseconds kBraking{2'000'000'000};

}  // namespace

StageThread::StageThread(StageController& controller, HostLine& line, ControllerTime time)
    : controller_(controller),
      line_(line),
      time_(std::move(time)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

std::string StageThread::Stop() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  return error_;
}

void StageThread::Run(const std::stop_token& stop) {
  TurnWait turns(time_);
  while (!stop.stop_requested()) {
    const auto idle = controller_.Turn();
    if (!idle) {
      error_ = idle.error().message;
      failed_ = true;
      return;
    }
    // A wait for the line ends later than a step is due.
    if (*idle < StageController::kPoll / 2) {
      turns.WaitFor(*idle);
    } else {
      line_.WaitFor(*idle);
      line_.Renew();
    }
  }
  BrakeToRest();
}

void StageThread::BrakeToRest() {
  controller_.Brake();
  const nanoseconds end = time_.clock() + kBraking;
  while (controller_.stage().running() && time_.clock() < end) {
    const auto idle = controller_.Turn();
    if (!idle) break;
    time_.wait_until(time_.clock() + *idle);
  }
  controller_.MakeSafe();
}

}  // namespace intaglio::reference_controller
