#include "tests/services/cell/one_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::cell {
namespace {

using namespace std::chrono_literals;

constexpr auto kSilence = 250ms;
constexpr double kNmPerMm = 1e6;

std::int32_t ToNm(double mm) {
  if (std::isnan(mm)) return INT32_MAX;
  return static_cast<std::int32_t>(
      std::llround(std::clamp(mm * kNmPerMm, -2.1e9, 2.1e9)));
}

Vec3 ToMm(double x_nm, double y_nm, double z_nm) {
  return Vec3(x_nm, y_nm, z_nm) / kNmPerMm;
}

link::WireSegment ToWire(const motion::Segment& s) {
  const Vec3 &p = s.end_position_mm, &v = s.end_velocity_mm_s;
  return {ToNm(p.x()), ToNm(p.y()),         ToNm(p.z()), ToNm(v.x()),  ToNm(v.y()),
          ToNm(v.z()), s.duration_subticks, s.pulse,     s.program_end};
}

intaglio_MotionFault FaultOf(link::StageFault fault) {
  switch (fault) {
    case link::StageFault::kNone:
      return intaglio_MOTION_OK;
    case link::StageFault::kStarved:
    case link::StageFault::kSafeState:  // the host was silent
      return intaglio_MOTION_STARVED;
    case link::StageFault::kLimit:
      return intaglio_MOTION_LIMIT;
    case link::StageFault::kFollowingError:
      return intaglio_MOTION_FOLLOWING_ERROR;
    case link::StageFault::kLate:
    case link::StageFault::kRunRefused:
      return intaglio_MOTION_LATE;
    default:
      return intaglio_MOTION_SAFE_STATE;
  }
}

}  // namespace

OneMachine::OneMachine(virtual_engraver::StageOptions stage_options,
                       virtual_engraver::LaserOptions laser_options)
    : stage_options_(std::move(stage_options)), laser_options_(std::move(laser_options)) {
  SwitchOn();
}

void OneMachine::SwitchOff() {
  stage.reset();
  laser.reset();
}

void OneMachine::SwitchOn() {
  ++laser_options_.power_up;
  stage = std::make_unique<virtual_engraver::Stage>(stage_options_);
  laser = std::make_unique<virtual_engraver::Laser>(laser_options_);
  fired_.clear();
  next_tick_s_ = std::chrono::duration<double>(now_).count();
}

void OneMachine::Cut(bool cut) {
  cut_ = cut;
  commands_left_ = UINT64_MAX;
}

bool OneMachine::TakesCommand() {
  if (commands_left_ == 0) cut_ = true;
  if (commands_left_ != UINT64_MAX && commands_left_ > 0) --commands_left_;
  return reachable();
}

void OneMachine::Advance() {
  now_ += 1ms;
  if (!stage) return;
  if (!cut_) reached_at_ = now_;
  if (now_ - reached_at_ > kSilence) {
    if (laser->is_live()) laser->EnterSafeState();
    if (stage->running()) stage->Fail(link::StageFault::kSafeState);
  }
  while (next_tick_s_ <= std::chrono::duration<double>(now_).count()) PassTick();
}

void OneMachine::PassTick() {
  stage->AdvanceTick(laser->rate_hz());
  if (laser->AdvanceTick(stage->in_position()) != 0) fired_.push_back(laser->tick());
  next_tick_s_ += 1 / laser->rate_hz();
}

OneController::OneController(OneMachine& machine, std::string serial_number)
    : machine_(machine), serial_number_(std::move(serial_number)) {}

void OneController::SetDown(intaglio_MotionFault fault, std::string why) {
  link_up_ = state_.link_up = false;
  state_.fault = fault;
  state_.message = message_ = std::move(why);
  ++state_.number;
}

void OneController::Connect() {
  const std::string there = machine_.stage->Identity().serial_number;
  machine_.laser->NewSession();
  if (there != serial_number_) {
    machine_.laser->SetShutters(0);
    machine_.laser->SetLamp({false, 0});
    machine_.stage->Abort();
    state_.refusal =
        "the controller is '" + there + "', the profile expects '" + serial_number_ + "'";
    return SetDown(intaglio_MOTION_WRONG_CONTROLLER, state_.refusal);
  }
  state_.refusal.clear();
  message_.clear();
  link_up_ = true;
  ++sessions_;
  status_number_ = 0;
  disarms_sent_ = 0;
  pasts_.clear();
  identity_ = machine_.laser->Identity();
  (void)machine_.stage->TakePositions();
}

void OneController::TakeState() {
  reported_at_ = machine_.now();
  status_ = machine_.laser->Report();
  ++status_number_;
  const link::MotionStatus motion = machine_.stage->Report();
  state_.link_up = true;
  state_.tick = motion.tick;
  state_.position_mm = ToMm(motion.x_nm, motion.y_nm, motion.z_nm);
  state_.velocity_mm_s = ToMm(motion.vx_counts, motion.vy_counts, motion.vz_counts);
  state_.run = motion.run;
  state_.covered_through_tick = motion.covered_through_tick;
  state_.at_rest = motion.at_rest;
  state_.following_error_max_um = motion.following_error_max_nm / 1e3;
  state_.fault = FaultOf(motion.fault);
  state_.message = state_.fault == intaglio_MOTION_OK ? "" : "clear the fault";
  ++state_.number;
}

void OneController::Refresh() {
  if (machine_.TakesCommand()) {  // the question for its state
    if (!link_up_) Connect();
    if (link_up_) TakeState();
  } else if (!machine_.stage || machine_.now() - reported_at_ > kSilence) {
    if (link_up_) SetDown(intaglio_MOTION_LINK_LOST, "check the cable and the power");
  }
}

void OneController::Poll() { Refresh(); }

void OneController::Poll(const ReportSink& sink, const PastSink& past) {
  Refresh();
  if (!link_up_ || !machine_.reachable()) return;
  for (const link::PulseReport& report : machine_.laser->TakeReports()) sink(report);
  for (const link::PastReport& report : std::exchange(pasts_, {})) past(report);
}

template <typename Action>
Status OneController::Command(Action action) {
  if (!link_up_) return Fail(ErrorCode::kLinkLost, message_);
  if (machine_.TakesCommand()) action();
  return {};
}

std::vector<drivers::LatchedPositions> OneController::TakePositions() {
  std::vector<drivers::LatchedPositions> all;
  if (!link_up_ || !machine_.reachable()) return all;
  for (const link::Positions& part : machine_.stage->TakePositions()) {
    all.push_back({part.run, part.first_tick, {}, {}});
    for (const auto& p : part.positions)
      all.back().positions_mm.push_back(ToMm(p.x_nm, p.y_nm, p.z_nm));
  }
  return all;
}

Status OneController::BeginRun(std::uint32_t run, std::uint64_t start_tick,
                               std::uint64_t) {
  begun_run_ = run;
  appended_ = 0;
  return Command([&] { machine_.stage->BeginRun({run, start_tick}); });
}

std::size_t OneController::Room() const {
  if (!link_up_ || !machine_.reachable()) return 0;
  return std::min<std::size_t>(machine_.stage->Report().queue_free, link::kMaxSegments);
}

Status OneController::Append(std::span<const motion::Segment> segments,
                             std::span<const std::uint64_t>) {
  link::Segments frame{begun_run_, appended_, {}};
  for (const motion::Segment& segment : segments)
    frame.segments.push_back(ToWire(segment));
  appended_ += segments.size();
  return Command([&] { machine_.stage->Append(frame); });
}

Status OneController::AbortRun() {
  return Command([this] { machine_.stage->Abort(); });
}
Status OneController::ClearFault() {
  return Command([this] { machine_.stage->Reset(); });
}
Status OneController::Lamp(bool on, double rate_hz) {
  return Command([&] { machine_.laser->SetLamp({on, rate_hz}); });
}
Status OneController::OpenShutters(std::uint8_t mask) {
  return Command([&] { machine_.laser->SetShutters(mask); });
}
Status OneController::Arm(const link::ArmWindow& window) {
  return Command([&] { machine_.laser->Decide(window); });
}
Status OneController::Disarm() {
  auto sent = Command([this] { machine_.laser->Disarm(); });
  if (sent) ++disarms_sent_;
  return sent;
}
Status OneController::Reset() {
  return Command([this] { machine_.laser->Reset(); });
}
Status OneController::Stop() {
  return Command([this] { machine_.laser->Stop(); });
}
Status OneController::RequestStatus() {
  return Command([] {});
}
bool OneController::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  return Command([&] {
           pasts_.push_back(machine_.laser->Past({first_tick, count}));
         })
      .has_value();
}

}  // namespace intaglio::cell
