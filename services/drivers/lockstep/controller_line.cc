#include "services/drivers/lockstep/controller_line.h"

#include <span>
#include <utility>

namespace intaglio::drivers {
namespace {

constexpr std::chrono::milliseconds kReopenPeriod{500};

}  // namespace

ControllerLine::ControllerLine(link::StreamOpener open, link::SteadyClock clock)
    : open_(std::move(open)), clock_(std::move(clock)) {}

bool ControllerLine::OpenStream() {
  if (now() < next_open_) return false;
  next_open_ = now() + kReopenPeriod;
  auto opened = open_();
  if (!opened) {
    message_ = opened.error().message;
    return false;
  }
  stream_ = std::move(*opened);
  message_ =
      "the controller does not answer: check its power, the cable and the baud rate";
  out_.clear();
  return true;
}

void ControllerLine::Write() {
  if (!stream_ || out_.empty() || !stream_->connected()) return;
  const auto taken = stream_->Write(std::as_bytes(std::span(out_)));
  // An error of the line is found by the next Read.
  if (taken) out_.erase(0, *taken);
}

}  // namespace intaglio::drivers
