#include "services/virtual_engraver/machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "services/virtual_engraver/lines/late_line.h"

namespace intaglio::virtual_engraver {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr auto kIdle = 10ms;
// A line with jitter is read this often, so that jitter is all that is added.
constexpr auto kLateLineIdle = 200us;
// Between two reads of the lines.
constexpr int kTicksAtOnce = 2048;

}  // namespace

Machine::Machine(const MachineOptions& options, Glass glass, link::SteadyClock clock)
    : options_(options),
      stage_(options.stage),
      laser_(options.laser),
      glass_(std::move(glass)),
      bodies_(options.bodies, options.block, options.further_stations),
      clock_(std::move(clock)),
      next_tick_at_(clock_()) {}

// In lockstep the machine's clock stops until the data under way have arrived.
std::unique_ptr<link::ByteStream> Machine::Delayed(
    std::unique_ptr<link::ByteStream> end) {
  if (!end || options_.line_jitter.count() <= 0 || options_.laser.lockstep) return end;
  return std::make_unique<LateLine>(std::move(end), options_.line_jitter,
                                    options_.seed + ++lines_plugged_, clock_);
}

void Machine::PlugLaserLine(std::unique_ptr<link::ByteStream> end) {
  laser_end_.Plug(Delayed(std::move(end)), clock_, options_.laser.lockstep);
}

void Machine::PlugMotionLine(std::unique_ptr<link::ByteStream> end) {
  stage_end_.Plug(Delayed(std::move(end)), clock_, options_.laser.lockstep);
}

void Machine::PlugOneLine(std::unique_ptr<link::ByteStream> end) {
  one_line_ = true;
  stage_end_.ShareLine(laser_end_.line());
  PlugLaserLine(std::move(end));
}

void Machine::PollLines() {
  if (!one_line_) {
    laser_end_.Poll();
    return stage_end_.Poll();
  }
  const bool is_new =
      laser_end_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
        stage_end_.Obey(static_cast<link::MotionFrame>(type), payload);
      });
  if (is_new) stage_end_.Greet();
}

// By the stage controller's own timer, whatever the lamp does.
void Machine::AdvanceJog() {
  const nanoseconds now = clock_();
  const nanoseconds passed = now - std::exchange(jogged_at_, now);
  if (stage_.jogging()) stage_.AdvanceJog(1e-9 * static_cast<double>(passed.count()));
  FeelBodies();
}

void Machine::FeelBodies() {
  if (!bodies_.any()) return;
  bodies_.Move(FocusAt(options_.positioner, stage_.place_mm(), stage_.block_mm()),
               laser_.tick(),
               [this](const formats::GlassCollision& met) { glass_.Add(met); });
}

void Machine::KeepSafe() {
  laser_end_.KeepSafe();
  stage_end_.KeepSafe();
}

bool Machine::MayPassTick() const {
  if (!laser_.CountsSync()) return false;
  if (!options_.laser.lockstep) return clock_() >= next_tick_at_;
  return laser_.NextIsDecided() && stage_.MayPass(laser_.rate_hz()) &&
         !laser_end_.line().is_full() && !stage_end_.own_line().is_full();
}

void Machine::DelaySync(double seconds) {
  sync_late_s_ += seconds;
  next_tick_at_ += nanoseconds(static_cast<std::int64_t>(1e9 * seconds / options_.speed));
}

void Machine::PassTick() {
  const double late_s = std::exchange(sync_late_s_, 0);
  stage_.AdvanceTick(1 / (1 / laser_.rate_hz() + late_s));
  FeelBodies();
  // What passes within the tick is known from its begin: nothing commands the stage anew
  // before the next one.
  const bool at_place = laser_.NextFiresAtPlace();
  const auto passed_mm = at_place ? stage_.PlaceOfCompare() : std::nullopt;
  const bool gate = at_place ? passed_mm.has_value() : stage_.in_position();
  const std::uint8_t channels = laser_.AdvanceTick(gate, late_s);
  if (channels != 0) Fire(channels, passed_mm ? *passed_mm : stage_.place_mm());
  next_tick_at_ +=
      nanoseconds(static_cast<std::int64_t>(1e9 / (laser_.rate_hz() * options_.speed)));
}

bool Machine::PassTicks() {
  int passed = 0;
  while (passed < kTicksAtOnce && laser_.tick() < stop_at_ && MayPassTick()) {
    PassTick();
    ++passed;
  }
  return passed > 0;
}

void Machine::Fire(std::uint8_t channels, const Vec3& place_mm) {
  unsigned missed = to_overlook_ > 0 ? blind_channels_ : 0;
  if (to_overlook_ > 0) --to_overlook_;
  // A fixed splitter: a closed shutter takes up its share, and leaves none to the others.
  const double energy_mj = options_.split_ratio * laser_.pulse_energy_mj();
  const double full_mj = options_.split_ratio * options_.laser.max_energy_mj;
  for (std::uint8_t channel = 0; channel < 4; ++channel) {
    if ((channels >> channel & 1) == 0) continue;
    if (to_miss_ > 0) {
      missed |= 1u << channel;
      continue;
    }
    const auto [station, focus] =
        TraceFocus(FocusAt(options_.positioner, place_mm, stage_.block_mm()) +
                       options_.channel_offset_mm[channel],
                   options_.block, options_.further_stations,
                   BeamSlopes(options_.positioner, place_mm));
    const double peak_left =
        PeakLeft(options_.block, focus.apart_mm, options_.wavelength_mm);
    const bool cracks =
        focus.in_glass && energy_mj * peak_left >= options_.crack_energy_mj;
    const double length_mm = CrackLengthMm(options_.crack_length_mm, energy_mj / full_mj);
    glass_.Add({laser_.tick(), focus.position_mm, energy_mj, channel, cracks,
                cracks ? length_mm : 0, station});
    if (!cracks || !laser_.CountsFlashAt(focus.position_mm.z())) missed |= 1u << channel;
  }
  if (to_miss_ > 0) --to_miss_;
  laser_.Missed(static_cast<std::uint8_t>(missed));
}

bool Machine::Rests() const {
  return !options_.laser.lockstep && !laser_.lamp_is_on() && !laser_.is_live() &&
         !stage_.running();
}

// A command that came behind the reports may have asked for one.
nanoseconds Machine::RestingIdle() const {
  const nanoseconds now = clock_();
  if (laser_end_.line().IsStatusDue(now) || stage_end_.own_line().IsStatusDue(now))
    return nanoseconds(0);
  return std::min(laser_end_.line().next_status(), stage_end_.own_line().next_status()) -
         now;
}

void Machine::SendReports(bool at_once) {
  const nanoseconds now = clock_();
  const bool rests = Rests();
  // A host does not wait for what begins as long as for what goes on.
  if (std::exchange(rested_, rests) && !rests) at_once = true;
  const nanoseconds period = rests ? kRestingStatusPeriod : kStatusPeriod;
  laser_end_.SendOutcomes();
  stage_end_.SendPositions();
  laser_end_.SendStatus(now, at_once, period);
  stage_end_.SendStatus(now, at_once, period);
  laser_end_.line().Flush();
  stage_end_.own_line().Flush();
}

nanoseconds Machine::Turn() {
  AdvanceJog();
  PollLines();
  KeepSafe();
  const bool passed = PassTicks();
  const bool blocked = options_.laser.lockstep && !MayPassTick();
  // A reported crack is in its file already, whatever happens to this program.
  (void)glass_.Flush();
  // The host waits for the data that a stopped machine still has to send.
  SendReports(blocked && passed);
  // Sent data have to leave before the next wait.
  PollLines();
  if (options_.laser.lockstep) return blocked ? nanoseconds(kIdle) : nanoseconds(0);
  if (options_.line_jitter.count() == 0 && Rests()) return RestingIdle();
  const nanoseconds idle = options_.line_jitter.count() > 0 ? kLateLineIdle : kIdle;
  return std::clamp(next_tick_at_ - clock_(), nanoseconds(0), idle);
}

std::string Machine::StatusLine() {
  const link::LaserStatus laser = laser_.Report();
  const Vec3& at = stage_.actual_mm();
  return fmt::format(
      "{{\"tick\": {}, \"rate_hz\": {}, \"interlocks\": {}, \"shutters\": {}, "
      "\"pulses\": {}, "
      "\"cracks\": {}, \"stage_mm\": [{}, {}, {}], \"block_mm\": [{}, {}], \"running\": "
      "{}, "
      "\"safe_state\": {}, \"outputs\": {}, \"inputs\": {}}}",
      laser.tick, laser.rate_hz, laser.interlocks, laser.shutters_open,
      laser_.made_pulse_count(), glass_.crack_count(), at.x(), at.y(), at.z(),
      stage_.block_mm().x(), stage_.block_mm().y(), stage_.running(),
      (laser.interlocks & link::kSafeState) != 0, laser_.accessories().on,
      laser_.accessories().levels);
}

}  // namespace intaglio::virtual_engraver
