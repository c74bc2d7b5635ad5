#include "services/synchronizer/cell_drive.h"

#include <fmt/format.h>

#include <utility>

#include "services/platform/bus/samples.h"

namespace intaglio::synchronizer {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;

constexpr auto kRepeatTime = 40ms;
const std::string kNoLens;

}  // namespace

CellDrive::CellDrive(bus::Bus& bus, std::string cell, std::string sender)
    : cell_(std::move(cell)),
      sender_(std::move(sender)),
      states_(bus, bus::kManualState, cell_),
      moves_(bus, bus::kCellMove, cell_) {}

void CellDrive::Start(Place place, const std::string& job_uid,
                      std::chrono::nanoseconds now) {
  place_ = std::move(place);
  job_uid_ = job_uid;
  drives_ = true;
  ++number_;
  attempts_ = 1;
  ends_at_ = now + place_.patience;
  known_by_ = now + kReportPatience;
  next_send_ = now;
  message_ = "the motion bridge has not answered: check that it runs";
}

void CellDrive::Stop() {
  if (!drives_) return;
  drives_ = false;
  Send();
}

void CellDrive::Turn(std::chrono::nanoseconds now) {
  states_.Take([this, now](const intaglio_ManualState& state) {
    seen_ = state.number;
    const bool ours =
        View(state.answered_sender) == sender_ && state.answered_number == number_;
    if (!drives_ || !ours) return;
    if (state.answer == intaglio_MANUAL_ACCEPTED) {
      message_ = fmt::format("it takes more than {} s: check the speed of the axes",
                             place_.patience / 1s);
      return;
    }
    // On a computer that was too busy to repeat it in time. What forbids motion refuses
    // the next attempt.
    if (state.answer == intaglio_MANUAL_STOPPED && attempts_ < kAttempts) {
      ++attempts_;
      ++number_;
      return;
    }
    if (state.reports_missing && now < known_by_) {
      ++number_;
      return;
    }
    drives_ = false;
    message_ = state.answer == intaglio_MANUAL_DONE ? "" : View(state.message);
  });
  if (drives_ && now >= ends_at_) Stop();
  if (!drives_ || now < next_send_) return;
  next_send_ = now + kRepeatTime;
  Send();
}

void CellDrive::Send() {
  intaglio_ManualCommand move{};
  move.cell = Borrow(cell_);
  move.sender = Borrow(sender_);
  move.number = number_;
  move.seen = seen_;
  move.kind = drives_ ? place_.kind : intaglio_MANUAL_NONE;
  move.operator_name = Borrow(sender_);
  for (int i = 0; i < 3; ++i) move.place[i] = place_.axes[i];
  move.speed_mm_s = place_.speed_mm_s;
  move.channel = 1;
  move.lens = Borrow(kNoLens);

  (void)moves_.Write(move);
}

}  // namespace intaglio::synchronizer
