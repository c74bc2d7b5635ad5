#include "services/marker/marker.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/marker/field_teacher.h"
#include "services/marker/hand_teacher.h"
#include "services/platform/bus/samples.h"

namespace intaglio::marker {
namespace {

using bus::Borrow;
// The loop turns every 5 ms and asks.
const auto kNoWakeOfMarker = [] {};
constexpr std::chrono::milliseconds kInterlockPeriod{50};

std::uint32_t BitsOf(const drivers::MarkDeviceState& state, bool stopped) {
  return (state.link_up ? 1u : 0u) | (state.key_on ? 2u : 0u) |
         (state.door_closed ? 4u : 0u) | (state.stop_released ? 8u : 0u) |
         (state.shutter_open ? 16u : 0u) | (state.safe_state ? 32u : 0u) |
         (stopped ? 64u : 0u);
}

std::unique_ptr<cell::Teacher> MakeTeacher(const MachineSpec& machine,
                                           const std::string& profile) {
  if (machine.has_scan_head()) return std::make_unique<FieldTeacher>(machine, profile);
  return std::make_unique<HandTeacher>();
}

}  // namespace

Marker::Marker(host::ServiceHost& host, const MachineSpec& machine,
               const std::string& profile, std::unique_ptr<drivers::MarkDriver> driver)
    : machine_(machine),
      cell_(machine.name()),
      driver_(std::move(driver)),
      intake_(host.bus(), host.instance(), bus::kOrderedMarkBatch),
      interlocks_(host.bus(), bus::kInterlock, cell_),
      reporter_(host.bus(), host.instance()),
      teacher_(MakeTeacher(machine, profile)),
      task_(host, cell_, *this) {
  if (drivers::HandMotion* hand = driver_->hand())
    desk_.emplace(host.bus(), cell_, *hand, *teacher_);
}

Marker::~Marker() = default;

void Marker::Turn(std::chrono::nanoseconds now) {
  now_ = now;
  if (journal_) journal_->ClearEvent();
  driver_->Poll();
  if (taken_over()) return;
  task_.Receive(now);
  task_.ReceiveTasks();
  if (!marking_) (void)driver_->TakeEvents();
  ReceiveMarks();
  AcceptPrepared();
  CheckZero();
  TurnByHand();
  task_.Turn();
  PublishInterlock();
  reporter_.Turn(now_);
}

// A run does not begin before the driver is settled: motion by hand ends by the arm.
void Marker::TurnByHand() {
  if (!desk_) return;
  using Activity = cell::WorkStates::Activity;
  const bool runs = marking_ && (marking_->activity() == Activity::kRuns ||
                                 marking_->activity() == Activity::kSettles);
  desk_->Turn(runs, task_.permission().stopped(), now_);
}

Status Marker::Begin(FrozenJob& job, const intaglio_StageTask& task) {
  INTAGLIO_TRY(CheckMarkTask(job, machine_));
  INTAGLIO_TRY(zero_.Begin(job, task.take_up));
  if (task.take_up) {
    Prepare(std::nullopt);
    return {};
  }
  return intake_.Open(job.job_uid(), task.attempt);
}

// Also when none is wanted: what is not taken would wake the loop again and again.
void Marker::ReceiveMarks() {
  const auto received = intake_.Poll();
  if (!task_.has_job() || marking_ || preparation_) return;
  if (!received) return task_.Fail(received.error());
  if (*received) Prepare(intake_.TakeContent());
}

void Marker::Prepare(std::optional<mark::MarkSet> marks) {
  preparation_ = std::make_unique<Preparation>(
      [job = task_.job(),
       marks = std::move(marks)](const ProgressSink& progress) mutable {
        return PrepareMarking(job, std::move(marks), progress);
      },
      kNoWakeOfMarker);
}

void Marker::AcceptPrepared() {
  std::erase_if(abandoned_, [](const auto& one) { return one->ready(); });
  if (!preparation_ || !preparation_->ready()) return;
  auto prepared = preparation_->Take();
  preparation_.reset();
  if (!prepared) return task_.Fail(prepared.error());
  MarkingJob& job = prepared->job;
  const cell::EarlierWork& earlier = job.earlier;
  task_.BeginWork(earlier, {earlier.power_up, earlier.openings},
                  task_.job().result_directory() + "/" + kJournalFile);
  journal_ = std::move(prepared->journal);
  marking_ =
      std::make_unique<Marking>(std::move(job), *driver_, *journal_, task_.chain());
}

// No run begins in the turn in which its grant was received: what the zero says of it is
// known before.
void Marker::CheckZero() {
  if (!marking_) return;
  zero_.Turn(task_.job(), driver_->state(),
             {.started = marking_->started(), .has_grant = task_.has_grant()});
}

void Marker::TurnWork(const cell::GrantInputs& inputs) {
  cell::GrantInputs with_zero = inputs;
  with_zero.zero_refusal = zero_.refusal();
  marking_->Turn(with_zero);
}

void Marker::Drop() {
  marking_.reset();
  journal_.reset();
  intake_.Close();
  if (!preparation_) return;
  preparation_->Cancel();
  abandoned_.push_back(std::move(preparation_));
}

void Marker::PublishInterlock() {
  const drivers::MarkDeviceState& state = driver_->state();
  const host::StopLatch& stop = task_.permission().stop();
  if (state.number != state_number_) state_at_ = now_;
  state_number_ = state.number;
  const std::uint32_t bits = BitsOf(state, stop.pressed());
  if (bits == published_interlocks_ && stop.revision() == stop_revision_ &&
      now_ < next_interlock_) {
    return;
  }
  published_interlocks_ = bits;
  stop_revision_ = stop.revision();
  next_interlock_ = now_ + kInterlockPeriod;
  intaglio_Interlock sample{};
  sample.cell = Borrow(cell_);
  sample.bus_stop_pressed = stop.pressed();
  const auto held = host::WireOf(stop.held());
  Borrow(sample.bus_stops, held);
  sample.laser_link_up = state.link_up;
  const std::string& message = state.refusal.empty() ? state.message : state.refusal;
  sample.message = Borrow(message);
  if (state.link_up) {
    sample.state_age_ms = bus::AgeMs(now_ - state_at_);
    sample.key_on = state.key_on;
    sample.door_closed = state.door_closed;
    sample.emergency_stop_released = state.stop_released;
    sample.safe_state = state.safe_state;
    sample.shutters_open = state.shutter_open ? 1 : 0;
  }
  (void)interlocks_.Write(sample);
  reporter_.Update(sample);
}

}  // namespace intaglio::marker
