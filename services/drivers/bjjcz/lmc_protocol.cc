#include "services/drivers/bjjcz/lmc_protocol.h"

#include <algorithm>
#include <cstdlib>

#include "engrave/core/check.h"

namespace intaglio::drivers {
namespace {

void AppendUint16(std::uint16_t number, std::string& bytes) {
  bytes += static_cast<char>(number & 0xFF);
  bytes += static_cast<char>(number >> 8);
}

}  // namespace

bool IsAnswered(LmcOperation operation) {
  return operation < static_cast<LmcOperation>(0x8000) &&
         operation != LmcOperation::kCorrectionLine;
}

void AppendCommand(const LmcCommand& command, std::string& bytes) {
  AppendUint16(static_cast<std::uint16_t>(command.operation), bytes);
  for (const std::uint16_t argument : command.arguments) AppendUint16(argument, bytes);
}

void AppendPacket(std::span<const LmcCommand> commands, std::string& bytes) {
  Require(commands.size() <= kLmcPacketCommands, "a packet of {} commands",
          commands.size());
  for (const LmcCommand& command : commands) AppendCommand(command, bytes);
  for (std::size_t i = commands.size(); i < kLmcPacketCommands; ++i)
    AppendCommand({}, bytes);
}

std::size_t LmcMessageBytes(std::span<const std::byte> bytes) {
  Require(bytes.size() >= 2, "a message of {} bytes", bytes.size());
  const bool is_packet = (bytes[1] & std::byte{0x80}) != std::byte{0};
  return is_packet ? kLmcPacketCommands * kLmcCommandBytes : kLmcCommandBytes;
}

std::uint16_t SignedNumber(int value) {
  constexpr int kSign = 0x8000;
  const int amount = std::min(std::abs(value), kSign - 1);
  return static_cast<std::uint16_t>(value < 0 ? kSign + amount : amount);
}

namespace {
constexpr std::uint32_t kAxisSign = 0x80000000;
}  // namespace

std::uint32_t AxisNumber(std::int32_t steps) {
  const auto amount = static_cast<std::uint32_t>(
      std::min<std::int64_t>(std::abs(std::int64_t{steps}), kAxisSign - 1));
  return steps < 0 ? kAxisSign | amount : amount;
}

std::int32_t StepsOfAxisNumber(std::uint32_t number) {
  const auto amount = static_cast<std::int32_t>(number & (kAxisSign - 1));
  return (number & kAxisSign) != 0 ? -amount : amount;
}

void LmcReplyReader::Feed(std::span<const std::byte> bytes) {
  bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::optional<LmcReply> LmcReplyReader::Next() {
  if (bytes_.size() < kLmcReplyBytes) return std::nullopt;
  LmcReply reply;
  for (std::size_t i = 0; i < reply.numbers.size(); ++i) {
    const auto low = static_cast<std::uint8_t>(bytes_[2 * i]);
    const auto high = static_cast<std::uint8_t>(bytes_[2 * i + 1]);
    reply.numbers[i] = static_cast<std::uint16_t>(low | high << 8);
  }
  bytes_.erase(0, kLmcReplyBytes);
  return reply;
}

}  // namespace intaglio::drivers
