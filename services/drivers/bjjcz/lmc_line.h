#pragma once

// The line to a BJJCZ board: opened again when it was lost, the board identified and set
// up, then one command at a time, the next when the one before was answered.
//
//   kClosed --opened--> kSerial --the expected one--> kStarting --all answered--> kUp
//      ^                   |                              |                        |
//      +---- another one --+------------------------------+--------- lost ---------+
//
// A board that is not the expected one is sent nothing but the question for its number,
// and let go: it may be that of another program, and the next opening may come to the
// expected one (usb_device.h). Each command and each packet is a write of its own,
// because on USB it is a transfer. The set-up first ends what an earlier host may have
// left in the board. The board gives no number of its power-up, and USB loses it when its
// cable is pulled as when its power is: each session is a power-up of its own.

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "services/drivers/bjjcz/lmc_protocol.h"
#include "services/drivers/lockstep/controller_line.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

struct LmcAnswer {
  LmcOperation operation = LmcOperation::kReadPort;
  LmcReply reply;
};

class LmcLine final : public ControllerLine {
 public:
  /// `set_up`: what each session begins with, behind the stop of what the board holds.
  LmcLine(link::StreamOpener open, link::SteadyClock clock, link::ExpectedDevice expected,
          std::vector<LmcCommand> set_up);

  /// Moves bytes. Appends the answers that came while it is up, in order; without a
  /// command it asks for the inputs every 5 ms. True: a session was lost.
  bool Poll(std::vector<LmcAnswer>& answers);

  bool up() const override { return phase_ == Phase::kUp; }
  /// All commands were written and answered.
  bool is_idle() const { return waiting_.empty() && !asked_; }
  void Send(const LmcCommand& command);
  /// Not before the board has room for it.
  void SendPacket(std::vector<LmcCommand> commands);
  /// What was not written.
  void DropWaiting() { waiting_.clear(); }

 private:
  enum class Phase { kClosed, kSerial, kStarting, kUp };
  /// A command, or a packet.
  struct Waiting {
    std::vector<LmcCommand> commands;
    bool is_packet = false;
  };

  void Open();
  /// False: the line is gone.
  bool Read(std::vector<LmcAnswer>& answers);
  void Receive(const LmcReply& reply, std::vector<LmcAnswer>& answers);
  void Identify(const LmcReply& reply);
  void WriteNext();
  void WriteMessages();
  void Ask(const LmcCommand& command);
  bool Lose(std::string why);

  link::ExpectedDevice expected_;
  std::vector<LmcCommand> set_up_;
  LmcReplyReader reader_;
  Phase phase_ = Phase::kClosed;
  std::deque<Waiting> waiting_;
  std::optional<LmcOperation> asked_;  ///< whose answer has not come
  bool ready_ = false;
  std::size_t message_left_ = 0;  ///< bytes of the message that is partly written
  std::chrono::nanoseconds asked_at_{0}, answered_at_{0};
};

}  // namespace intaglio::drivers
