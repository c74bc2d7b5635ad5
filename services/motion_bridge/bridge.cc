#include "services/motion_bridge/bridge.h"

#include <algorithm>
#include <cmath>

#include "services/job/machine/position_tolerance.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::motion_bridge {
namespace {

using bus::Borrow;
using bus::View;

constexpr std::uint32_t kWindowBatches = 16;
// A state is worth a sample when more than the time has changed, and at least this often:
// readers take its absence for 500 ms for a dead bridge.
constexpr std::chrono::milliseconds kUnchangedPeriod{100};
// Between two attempts to bring the stage to rest or to clear its fault.
constexpr std::chrono::milliseconds kPreparationPeriod{20};

std::vector<motion::Segment> SegmentsOf(const intaglio_MotionSegmentBatch& sample) {
  const auto x = View(sample.x_mm), y = View(sample.y_mm), z = View(sample.z_mm);
  const auto vx = View(sample.vx_mm_s), vy = View(sample.vy_mm_s),
             vz = View(sample.vz_mm_s);
  const auto duration = View(sample.duration_subticks);
  const auto pulse = View(sample.pulse);
  const std::size_t count = duration.size();
  const std::size_t times = View(sample.controller_ns).size();
  if (times != 0 && times != count) return {};
  for (const std::size_t size :
       {x.size(), y.size(), z.size(), vx.size(), vy.size(), vz.size(), pulse.size()}) {
    if (size != count) return {};
  }
  std::vector<motion::Segment> segments(count);
  for (std::size_t i = 0; i < count; ++i) {
    segments[i].end_position_mm = Vec3(x[i], y[i], z[i]);
    segments[i].end_velocity_mm_s = Vec3(vx[i], vy[i], vz[i]);
    segments[i].duration_subticks = duration[i];
    segments[i].pulse = pulse[i] != 0;
  }
  if (sample.last && !segments.empty()) segments.back().program_end = true;
  return segments;
}

// What is published a thousand times a second is recorded, too: numbers with short binary
// fractions take two thirds of the space. 2^-20 mm is a nanometre, 2^-10 mm/s a
// micrometre a second; the motion line resolves no more than the former.
double Rounded(double value, int bits) {
  return std::ldexp(std::nearbyint(std::ldexp(value, bits)), -bits);
}
double PlaceOf(double mm) { return Rounded(mm, 20); }
double SpeedOf(double mm_s) { return Rounded(mm_s, 10); }

}  // namespace

Bridge::Bridge(host::ServiceHost& host, const MachineSpec& machine, std::string profile,
               std::unique_ptr<drivers::MotionDriver> driver)
    : host_(host),
      cell_(machine.name()),
      position_tolerance_um_(machine.position_tolerance_um()),
      driver_(std::move(driver)),
      batches_(host.bus(), bus::kMotionSegmentBatch, cell_),
      stops_(host.bus(), bus::kEmergencyStop, cell_),
      states_(host.bus(), bus::kMotionState, cell_),
      positions_(host.bus(), bus::kPositionReport, cell_),
      reporter_(host.bus(), host.instance()),
      credit_(host.bus(), host.instance()),
      teacher_(machine, std::move(profile)),
      manual_(host.bus(), cell_, *driver_, teacher_) {}

void Bridge::Turn(std::chrono::nanoseconds now) {
  driver_->Poll();
  if (driver_->state().taken_over) return;
  AlarmRefusal();
  AlarmTolerance();
  TakeBatches();
  TakeStops();
  manual_.Turn(phase_ != Phase::kIdle || abort_owed_, stop_.pressed(), now);
  // A line full of segments takes the abort as soon as it can.
  if (abort_owed_) abort_owed_ = !driver_->AbortRun();
  if (abort_owed_) return PublishAll(now);
  if (phase_ == Phase::kBeginning && !manual_.moves()) Begin(now);
  if (phase_ == Phase::kFeeding) Feed();
  PublishAll(now);
}

// Once for each device that is refused; a line that comes and goes raises no more.
void Bridge::AlarmRefusal() {
  const drivers::DriverState& state = driver_->state();
  if (state.link_up) alarmed_refusal_.clear();
  if (state.refusal.empty() || state.refusal == alarmed_refusal_) return;
  alarmed_refusal_ = state.refusal;
  host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kRefused),
                   alarmed_refusal_);
}

// Once for each controller that answers with another tolerance than the profile's.
void Bridge::AlarmTolerance() {
  const drivers::DriverState& state = driver_->state();
  if (!state.link_up) return;
  std::string mismatch =
      ToleranceMismatch(state.position_tolerance_um, position_tolerance_um_);
  if (mismatch == tolerance_mismatch_) return;
  tolerance_mismatch_ = std::move(mismatch);
  if (tolerance_mismatch_.empty()) return;
  host_.RaiseAlarm(intaglio_ALARM_WARNING, "tolerance_mismatch", tolerance_mismatch_);
}

std::string Bridge::message() const {
  return state().message.empty() ? tolerance_mismatch_ : state().message;
}

std::chrono::milliseconds Bridge::wait() const {
  const bool rests = phase_ == Phase::kIdle && !abort_owed_ && !manual_.moves() &&
                     state().link_up && state().at_rest;
  return rests ? driver_->resting_wait() : drivers::MotionDriver::kRestingWait;
}

void Bridge::PublishAll(std::chrono::nanoseconds now) {
  PublishPositions();
  PublishState(now);
  reporter_.Turn(now);
}

void Bridge::TakeBatches() {
  batches_.Take([this](const intaglio_MotionSegmentBatch& sample) { Accept(sample); });
}

void Bridge::Accept(const intaglio_MotionSegmentBatch& sample) {
  if (sample.abort) {
    if (sample.run < run_) return;
    run_ = sample.run;
    AbortRun();
    return;
  }
  if (sample.run > run_) StartRun(sample);
  if (sample.run != run_ || phase_ == Phase::kIdle) return;
  if (sample.sequence_number != expected_batch_) {
    host_.RaiseAlarm(
        intaglio_ALARM_FAULT, "link_lost",
        fmt::format("motion batch {} of run {} is missing; the run is aborted",
                    expected_batch_, run_));
    AbortRun();
    return;
  }
  if (const auto granted = credit_.CheckGranted(stream_, sample.sequence_number);
      !granted) {
    host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(granted.error().code),
                     granted.error().message);
    AbortRun();
    return;
  }
  ++expected_batch_;
  const auto times = View(sample.controller_ns);
  queue_.push_back({sample.sequence_number,
                    SegmentsOf(sample),
                    {times.begin(), times.end()},
                    0,
                    sample.last});
}

void Bridge::StartRun(const intaglio_MotionSegmentBatch& sample) {
  EndRun();
  run_ = sample.run;
  start_tick_ = sample.start_tick;
  start_controller_ns_ = sample.start_controller_ns;
  block_mm_ = Vec2(sample.block_x_mm, sample.block_y_mm);
  expected_batch_ = 0;
  stream_ = bus::StreamName(std::string(View(sample.job_uid)), sample.run,
                            bus::kMotionSegmentBatch.name);
  if (auto opened = credit_.Open(stream_, batches_.guid(), kWindowBatches); !opened) {
    host::LogError("no credit for {}: {}", stream_, opened.error().message);
  }
  phase_ = Phase::kBeginning;
  next_preparation_ = {};
}

void Bridge::EndRun() {
  queue_.clear();
  phase_ = Phase::kIdle;
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
}

void Bridge::AbortRun() {
  EndRun();
  abort_owed_ = !driver_->AbortRun();
}

void Bridge::TakeStops() {
  stops_.Take([this](const intaglio_EmergencyStop& stop) {
    if (!stop_.Receive(stop)) return;
    AbortRun();
    host::LogWarning("emergency stop: the stage brakes");
  });
  // A run that came while it was pressed does not begin when it is reset.
  if (stop_.pressed() && phase_ != Phase::kIdle) AbortRun();
}

void Bridge::Begin(std::chrono::nanoseconds now) {
  const drivers::DriverState& state = driver_->state();
  if (!state.link_up) return;
  if (state.fault == intaglio_MOTION_OK && state.at_rest) {
    if (const Status block = driver_->RequireBlockAt(block_mm_); !block) {
      host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(block.error().code),
                       block.error().message);
      return AbortRun();
    }
    if (driver_->BeginRun(run_, start_tick_, start_controller_ns_))
      phase_ = Phase::kFeeding;
    return;
  }
  if (now < next_preparation_) return;
  next_preparation_ = now + kPreparationPeriod;
  (void)(state.fault != intaglio_MOTION_OK ? driver_->ClearFault() : driver_->AbortRun());
}

void Bridge::Feed() {
  while (!queue_.empty()) {
    Batch& batch = queue_.front();
    const auto rest = std::span(batch.segments).subspan(batch.appended);
    if (!rest.empty()) {
      const auto part = rest.first(std::min(rest.size(), driver_->Room()));
      auto times = std::span<const std::uint64_t>(batch.controller_ns);
      if (!times.empty()) times = times.subspan(batch.appended, part.size());
      if (part.empty() || !driver_->Append(part, times)) return;
      batch.appended += part.size();
      continue;
    }
    (void)credit_.Consumed(stream_, batch.number + 1);
    const bool last = batch.last;
    queue_.pop_front();
    if (last) return EndRun();
  }
}

void Bridge::PublishPositions() {
  std::vector<double> x, y, z;
  for (const drivers::LatchedPositions& latched : driver_->TakePositions()) {
    x.clear(), y.clear(), z.clear();
    for (const Vec3& p : latched.positions_mm) {
      x.push_back(p.x());
      y.push_back(p.y());
      z.push_back(p.z());
    }
    intaglio_PositionReport report{};
    report.cell = Borrow(cell_);
    report.run = latched.run;
    report.sequence_number = position_number_++;
    report.first_tick = latched.first_tick;
    Borrow(report.x_mm, x);
    Borrow(report.y_mm, y);
    Borrow(report.z_mm, z);
    Borrow(report.at_ns, latched.at_ns);
    report.clock = driver_->state().clock;
    (void)positions_.Write(report);
  }
}

void Bridge::PublishState(std::chrono::nanoseconds now) {
  const drivers::DriverState& state = driver_->state();
  PublishedState newest{state, std::max(run_, state.run), stop_.revision()};
  // They grow with every report of a stage that rests without a run.
  newest.driver.tick = newest.driver.number = 0;
  if (state.run == 0) newest.driver.covered_through_tick = 0;
  if (newest == published_ && now < next_state_) return;
  published_ = std::move(newest);
  next_state_ = now + kUnchangedPeriod;
  intaglio_MotionState sample{};
  sample.cell = Borrow(cell_);
  sample.tick = state.tick;
  sample.x_mm = PlaceOf(state.position_mm.x());
  sample.y_mm = PlaceOf(state.position_mm.y());
  sample.z_mm = PlaceOf(state.position_mm.z());
  sample.vx_mm_s = SpeedOf(state.velocity_mm_s.x());
  sample.vy_mm_s = SpeedOf(state.velocity_mm_s.y());
  sample.vz_mm_s = SpeedOf(state.velocity_mm_s.z());
  sample.run = state.run;
  sample.highest_run = published_.run;
  sample.covered_through_tick = state.covered_through_tick;
  sample.at_rest = state.at_rest;
  sample.following_error_max_um = state.following_error_max_um;
  const drivers::MotionHindrance hindrance = FindHindrance(state);
  sample.fault = hindrance.fault;
  sample.message = Borrow(hindrance.message);
  sample.clock = state.clock;
  sample.position_tolerance_um = state.position_tolerance_um;
  sample.has_block_stage = state.has_block_stage;
  sample.block_x_mm = PlaceOf(state.block_mm.x());
  sample.block_y_mm = PlaceOf(state.block_mm.y());
  const auto held = host::WireOf(stop_.held());
  Borrow(sample.bus_stops, held);
  (void)states_.Write(sample);
  reporter_.Update(sample);
}

}  // namespace intaglio::motion_bridge
