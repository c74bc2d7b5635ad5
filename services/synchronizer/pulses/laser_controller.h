#pragma once

// The laser controller at the end of the laser line, as the synchronizer sees it.
//
// A controller with another serial number than the expected one is refused at the
// handshake. For the user of this class its line is down: up() is false, nothing of it is
// taken, and nothing is sent but, once a session, "shutters closed, disarm, lamp off". So
// it is when the cable was swapped while the process runs.
// Not thread-safe; nothing blocks.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "services/platform/link/expected_device.h"
#include "services/platform/link/laser_protocol.h"
#include "services/platform/link/line_session.h"

namespace intaglio::synchronizer {

class LaserController {
 public:
  using ReportSink = std::function<void(const link::PulseReport&)>;
  /// A status comes every 20 ms; without one nothing is known of the interlocks.
  static constexpr std::chrono::milliseconds kStatusLease{500};
  using PastSink = std::function<void(const link::PastReport&)>;

  LaserController(link::StreamOpener open, link::SteadyClock clock,
                  link::ExpectedDevice expected = {});

  /// Moves bytes and takes what came; `sink` gets every pulse report once, in order,
  /// `past` every answer to RequestPast.
  void Poll(const ReportSink& sink, const PastSink& past = nullptr);

  /// Up, identified, and a status of this session has come.
  bool up() const { return session_.up() && identified_ && status_number_ > 0; }
  /// Not before the identity has come: a Disarm of a session that is not known yet would
  /// be counted by the controller and not by us.
  bool CanSend() const { return session_.CanSend() && identified_; }
  /// A newer host has the controller; for good, and nothing more is said to it.
  bool taken_over() const { return session_.fenced(); }
  /// Why the line is down; empty while it is up.
  const std::string& message() const {
    return refusal_.empty() ? session_.message() : refusal_;
  }
  /// Why the controller that answers now is refused, and what to do; empty: it is not.
  const std::string& refusal() const { return refusal_; }
  int fd() const { return session_.fd(); }

  const link::LaserIdentity& identity() const { return identity_; }
  const link::LaserStatus& status() const { return status_; }
  /// Statuses of this session; grows with each.
  std::uint64_t status_number() const { return status_number_; }
  /// Up, and the newest status is young enough to act on.
  bool IsFresh(std::chrono::nanoseconds now) const {
    return up() && now - status_at_ < kStatusLease;
  }
  /// Grows with every session, i.e. whenever what was sent may have been lost.
  std::uint64_t session() const { return sessions_; }
  /// A status that was made after the newest Disarm of this session has come.
  bool disarmed() const { return up() && status_.disarms_taken == disarms_sent_; }
  bool Has(link::InterlockBits bit) const { return (status_.interlocks & bit) != 0; }

  Status Lamp(bool on, double rate_hz);
  Status OpenShutters(std::uint8_t mask);
  Status Arm(const link::ArmWindow& window);
  Status Disarm();
  Status Reset();
  /// Emergency stop, which the controller keeps latched until Reset.
  Status Stop();
  Status RequestStatus();
  /// Asks what came of `count` ticks (1..link::kMaxReportTicks), whichever session armed
  /// them. False: the line takes nothing now. A new session loses what was asked before.
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count);

 private:
  void Handle(link::LaserFrame type, std::span<const std::byte> payload,
              const ReportSink& sink, const PastSink& past);
  void Identify(std::span<const std::byte> payload);
  void Refuse(const std::string& why);
  Status SendFrame(link::LaserFrame type, const link::Bytes& payload = {});

  link::SteadyClock clock_;
  link::ExpectedDevice expected_;
  std::string refusal_;
  link::LineSession session_;
  link::LaserIdentity identity_;
  link::LaserStatus status_;
  bool identified_ = false;
  bool identified_now_ = false, refused_now_ = false;  // in this Poll
  std::uint32_t polled_sessions_ = 0;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0};
  std::uint64_t sessions_ = 0;
  std::uint32_t disarms_sent_ = 0;
};

}  // namespace intaglio::synchronizer
