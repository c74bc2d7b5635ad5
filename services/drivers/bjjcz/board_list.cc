#include "services/drivers/bjjcz/board_list.h"

#include <algorithm>
#include <cmath>

namespace intaglio::drivers {
namespace {

using enum LmcOperation;

constexpr double kMaxLmcNumber = 65535;
constexpr double kWidthClock_hz = 20e6;
constexpr double kMaxCurrent = 4095;
// The first pulses that a tube or a UV laser holds back: 6.7 us at 30 kHz.
constexpr double kFirstPulsePart = 67.0 / 333;
// The master oscillator of a fibre laser takes this time, 10 us.
constexpr std::uint16_t kOscillatorDelay = 800;
constexpr double kLateFactor = 2, kLateSeconds = 1;

}  // namespace

std::uint16_t ToUint16(double value) {
  return static_cast<std::uint16_t>(std::clamp(std::round(value), 0.0, kMaxLmcNumber));
}

std::uint16_t Microseconds(double seconds) { return ToUint16(1e6 * seconds); }

double PeriodClockHz(const BjjczBoard& board) {
  return board.laser() == BJJCZ_LASER_FIBRE ? 20e6 : 10e6;
}

void AppendLaser(const BjjczBoard& board, double power_ratio, double frequency_hz,
                 std::vector<LmcCommand>& commands) {
  const double period = PeriodClockHz(board) / frequency_hz;
  if (board.laser() == BJJCZ_LASER_FIBRE) {
    commands.push_back({kCurrent, {ToUint16(kMaxCurrent * power_ratio)}});
    commands.push_back({kQSwitchPeriod, {ToUint16(period)}});
    if (board.has_pulse_width_ns())
      commands.push_back({kPulseWidth, {ToUint16(board.pulse_width_ns())}});
    return;
  }
  const std::uint16_t first = ToUint16(kFirstPulsePart * period);
  commands.push_back({kMarkPeriod, {ToUint16(period)}});
  commands.push_back({kCo2FirstPulse, {first, first}});
  commands.push_back(
      {kPowerRatio, {ToUint16(kWidthClock_hz * power_ratio / frequency_hz)}});
}

void BeginList(const BjjczBoard& board, bool first_of_run, LmcList& list) {
  list.commands.push_back({kReadyMark, {}});
  if (!first_of_run || board.laser() != BJJCZ_LASER_FIBRE) return;
  list.commands.push_back({kDelay, {kOscillatorDelay}});
  list.seconds += 1e-5 * kOscillatorDelay;
}

void SendList(const LmcList& list, LmcLine& line) {
  line.Send({kResetList, {}});
  for (std::size_t at = 0; at < list.commands.size(); at += kLmcPacketCommands) {
    const auto from = list.commands.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t count = std::min(kLmcPacketCommands, list.commands.size() - at);
    line.SendPacket({from, from + static_cast<std::ptrdiff_t>(count)});
    line.Send({kEndOfList, {0}});
  }
}

void SendStop(std::uint16_t outputs, LmcLine& line) {
  line.DropWaiting();
  line.Send({kWritePort, {outputs}});
  line.Send({kStopExecute, {}});
  line.Send({kFibreOscillator, {0}});
  // Some boards act on the next list alone.
  line.Send({kResetList, {}});
  line.SendPacket({});
  line.Send({kEndOfList, {0}});
  line.Send({kExecuteList, {}});
  line.Send({kReadPort, {}});
}

void PlayedList::Execute(LmcLine& line) {
  line.Send({kExecuteList, {}});
  was_sent_ = true;
}

void PlayedList::Receive(const LmcAnswer& answer, std::chrono::nanoseconds now) {
  if (answer.operation == kExecuteList) executed_at_ = now;
  if (executed_at_ && answer.reply.is_busy()) was_busy_ = true;
}

double PlayedList::SecondsSince(std::chrono::nanoseconds now) const {
  return std::chrono::duration<double>(now - *executed_at_).count();
}

bool PlayedList::HasEnded(bool busy, std::chrono::nanoseconds now) const {
  return executed_at_ && !busy && (was_busy_ || SecondsSince(now) > seconds_);
}

bool PlayedList::IsLate(std::chrono::nanoseconds now) const {
  return executed_at_ && SecondsSince(now) > kLateFactor * seconds_ + kLateSeconds;
}

}  // namespace intaglio::drivers
