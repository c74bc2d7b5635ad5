#include "tests/services/drivers/bjjcz/bjjcz_machine.h"

#include <array>
#include <span>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

bjjcz::VirtualBjjczOptions BoardOf(bool needs_oscillator, bool interlocked) {
  bjjcz::VirtualBjjczOptions options;
  options.needs_oscillator = needs_oscillator;
  if (interlocked) options.interlock_input = kBjjczDoorInput;
  return options;
}

}  // namespace

BjjczMachine::BjjczMachine(bool needs_oscillator, bool interlocked)
    : board(BoardOf(needs_oscillator, interlocked)) {}

void BjjczMachine::Cut(bool cut) {
  if (!to_board_) return;
  to_board_->cut = to_host_->cut = cut;
  to_board_->cut_after = UINT64_MAX;
}

void BjjczMachine::CutAfter(std::uint64_t bytes) {
  if (to_board_) to_board_->cut_after = to_board_->taken_count + bytes;
}

void BjjczMachine::Advance() {
  now_ += 1ms;
  if (end_) {
    std::array<std::byte, 97> bytes;
    while (const std::size_t count = end_->Read(bytes).value_or(0))
      board.Write({reinterpret_cast<const char*>(bytes.data()), count});
  }
  board.Advance(1000);
  const std::string sent = board.Read();
  if (end_ && !sent.empty()) (void)end_->Write(std::as_bytes(std::span(sent)));
  if (to_board_ && to_board_->cut) to_host_->cut = true;
}

link::StreamOpener BjjczMachine::Opener() {
  return [this]() -> Result<std::unique_ptr<link::ByteStream>> {
    const bool cut = to_board_ && to_board_->cut;
    to_board_ = std::make_shared<link::FaultyPipe>();
    to_host_ = std::make_shared<link::FaultyPipe>();
    to_board_->cut = to_host_->cut = cut;
    board.Reopen();
    end_ = std::make_unique<link::FaultyEnd>(to_board_, to_host_, random_, clock());
    return std::make_unique<link::FaultyEnd>(to_host_, to_board_, random_, clock());
  };
}

}  // namespace intaglio::drivers
