#pragma once

// Serves the laser that hangs on a motion controller to the synchronizer of the same
// cell: the device's side of the laser line (services/platform/link/laser_protocol.h) in
// front of a laser driver. So the synchronizer's driver and all that laser_controller.h
// guarantees hold as for a controller at the end of a cable.
//
//              Plug                 session agreed            Disarm confirmed
//   no host ----------> opening ------------------> disarming -----------------> serving
//      ^                                                                            |
//      +------ the host's end is closed, or silent for 2 s; the laser is lost ------+
//
// Only in `serving` an arm is passed on. A new session, a lost host and 250 ms without a
// valid frame of it close the shutters and disarm, and hold that (kSafeState) until the
// host commands Reset. A Disarm overtakes everything that waits, and counts in the status
// only once the driver has confirmed it. The host sees the laser's line as its own: while
// it is lost there is no session.
//
// If this process dies, the controller's line is silent, and L7 closes it.
// Not thread-safe; nothing blocks.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "services/drivers/interface/laser_controller.h"
#include "services/platform/link/reliable_link.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class LaserOutput {
 public:
  LaserOutput(LaserController& laser, link::SteadyClock clock);

  /// A host would be served. While it is false there is none.
  bool ready() const { return laser_.up(); }
  bool has_host() const { return link_ != nullptr; }
  /// The end of a new host; the one before, if any, is closed. A host whose number is
  /// below the highest that came is refused (link::LineEpoch).
  void Plug(std::unique_ptr<link::ByteStream> end);
  /// Moves everything: laser, host, and what waits between them.
  void Poll();
  /// Closes the laser and leaves the host, before an orderly end: then Poll until
  /// closed().
  void Close();
  bool closed() const { return !close_owed_ && laser_.disarmed(); }
  /// The host's; -1 when there is none.
  int fd() const { return link_ ? link_->fd() : -1; }

 private:
  struct Frame {
    link::LaserFrame type;
    link::Bytes payload;
  };

  void PollLaser();
  void FollowLaser();
  void PollHost();
  void BeginSession();
  void Unplug();
  void EnterSafeState();
  void Receive(link::LaserFrame type, std::span<const std::byte> payload);
  void TakeAtOnce(link::LaserFrame type);
  void Queue(link::LaserFrame type, std::span<const std::byte> payload);
  void CloseLaser();
  void PassCommandsOn();
  bool PassOn(const Frame& command);
  bool MustGiveUp();
  Status Obey(const Frame& command);
  void ReportDark(const Frame& command, link::TickOutcome outcome);
  void Identify();
  void SendStatus();
  void Send(link::LaserFrame type, link::Bytes payload);
  void Flush();

  LaserController& laser_;
  link::SteadyClock clock_;
  std::shared_ptr<link::LineEpoch> epoch_ = std::make_shared<link::LineEpoch>();
  std::unique_ptr<link::ReliableLink> link_;
  std::uint32_t link_session_ = 0;
  std::uint64_t laser_session_ = 0;
  bool serving_ = false;  // the host has the identity
  bool safe_state_ = true;
  bool close_owed_ = true, disarm_owed_ = false, stop_owed_ = false;
  std::deque<Frame> commands_;  // of the host, in order, not passed on yet
  std::deque<Frame> outgoing_;  // to the host
  std::optional<std::chrono::nanoseconds> refused_at_;  // the first command, since then
  std::uint32_t disarms_taken_ = 0, disarms_confirmed_ = 0, disarms_sent_ = 0;
  bool status_asked_ = false;
  std::uint64_t status_number_ = 0;
  std::uint32_t sent_interlocks_ = 0;
  std::chrono::nanoseconds next_status_{0};
};

}  // namespace intaglio::drivers
