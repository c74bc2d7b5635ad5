#pragma once

// What passes between a host and a BJJCZ board (LMC, of EzCad 2), over USB or a socket.
// The makers publish nothing: numbers and units are those that public programs use
// (galvoplotter, meerk40t), and no other is used here.
//
//   host   12 bytes: six uint16, little-endian: operation and five arguments. An
//          operation below 0x8000 is done at once and answered; a correction line is not.
//   host 3072 bytes: 256 such commands from 0x8000 on, a packet of the list; not
//   answered. board   8 bytes: four uint16; the last is the status.
//
// Places: 0..65535, the centre of the field is 32768. Speeds: places a millisecond.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace intaglio::drivers {

inline constexpr std::size_t kLmcCommandBytes = 12, kLmcReplyBytes = 8,
                             kLmcPacketCommands = 256;

enum class LmcOperation : std::uint16_t {
  kEnableLaser = 0x04,
  kExecuteList = 0x05,
  kPwmPulseWidth = 0x06,
  kSerialNumber = 0x09,
  kCorrectionLine = 0x10,  ///< dx, dy as SignedNumber, 0 at the first and 1 at the others
  kResetList = 0x12,
  kCorrectionTable = 0x15,  ///< 1: lines follow; 0: none is used
  kControlMode = 0x16,
  kDelayMode = 0x17,
  kEndOfList = 0x19,  ///< behind each packet, 0
  kFirstPulse = 0x1A,
  kLaserMode = 0x1B,
  kTiming = 0x1C,
  kStandby = 0x1D,
  kPwmHalfPeriod = 0x1E,
  kStopExecute = 0x1F,
  kWritePort = 0x21,  ///< bits of the outputs
  kAnalogPort1 = 0x22,
  kReadPort = 0x25,    ///< answer: number 1 has the bits of the inputs
  kAxisSpeed = 0x26,   ///< lowest and highest, steps/s
  kAxisRamp = 0x27,    ///< from the lowest to the highest, ms
  kAxisOrigin = 0x28,  ///< goes to its switch, where it counts from
  kAxisTo = 0x29,      ///< low and high half of AxisNumber
  kAxisPlace = 0x2A,   ///< answer: numbers 1 and 2 are the high and the low half
  kFirstPulseKiller = 0x2E,
  kFlyResolution = 0x32,
  kFibreOscillator = 0x33,  ///< 1: the master oscillator is on
  kEnableZ = 0x3A,
  kReset = 0x40,
  // In a list.
  kJump = 0x8001,           ///< x, y, angle 0, distance
  kEnd = 0x8002,            ///< also fills a packet
  kLaserOnPoint = 0x8003,   ///< the laser is on at rest, 10 us
  kDelay = 0x8004,          ///< 10 us
  kMark = 0x8005,           ///< x, y, angle 0, distance
  kJumpSpeed = 0x8006,      ///< places/ms
  kLaserOnDelay = 0x8007,   ///< us, 0x8000: negative
  kLaserOffDelay = 0x8008,  ///< us, 0x8000: negative
  kMarkPeriod = 0x800A,     ///< 0.1 us, CO2 and UV
  kPowerRatio = 0x800B,     ///< width of the pulse, 0.05 us, CO2 and UV
  kMarkSpeed = 0x800C,      ///< places/ms
  kJumpDelay = 0x800D,      ///< us
  kPolygonDelay = 0x800F,   ///< us
  kCurrent = 0x8012,        ///< 0..4095, fibre
  kQSwitchPeriod = 0x801B,  ///< 0.05 us, fibre
  kCo2FirstPulse = 0x801E,  ///< 0.1 us, twice
  kPulseWidth = 0x8026,     ///< ns, fibre
  kReadyMark = 0x8051,      ///< begins a list
};

struct LmcCommand {
  LmcOperation operation = LmcOperation::kEnd;
  std::array<std::uint16_t, 5> arguments{};
};

struct LmcReply {
  std::array<std::uint16_t, 4> numbers{};
  bool is_busy() const { return (numbers[3] & 0x04) != 0; }    ///< a list is executed
  bool is_moving() const { return (numbers[3] & 0x40) != 0; }  ///< the axis moves
  bool is_ready() const {
    return (numbers[3] & 0x20) != 0;
  }  ///< there is room for a packet
};

/// Whether the board answers it.
bool IsAnswered(LmcOperation operation);

/// 12 bytes are appended.
void AppendCommand(const LmcCommand& command, std::string& bytes);
/// 3072 bytes are appended, filled with kEnd; at most 256 commands.
void AppendPacket(std::span<const LmcCommand> commands, std::string& bytes);

/// Of the command or packet that `bytes` begin with; at least two.
std::size_t LmcMessageBytes(std::span<const std::byte> bytes);

/// Sign and amount, as correction lines have them; beyond +-32767 the nearest.
std::uint16_t SignedNumber(int value);

/// Sign in bit 31 and amount, as the axis has its steps; and back.
std::uint32_t AxisNumber(std::int32_t steps);
std::int32_t StepsOfAxisNumber(std::uint32_t number);

/// The answers out of bytes that come in any pieces.
class LmcReplyReader {
 public:
  void Feed(std::span<const std::byte> bytes);
  /// The next that is whole.
  std::optional<LmcReply> Next();
  void Clear() { bytes_.clear(); }

 private:
  std::string bytes_;
};

}  // namespace intaglio::drivers
