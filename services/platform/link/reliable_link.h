#pragma once

// A serial line that loses, doubles and corrupts bytes, made into a channel that delivers
// every frame once and in order, or reports that it is down.
//
//   host                              device
//    | -- kOpen(session, 0) ---------> |   host draws a session number, asks
//    | <---- kRefused(session, 41) --- |   the newest host so far was 41
//    | -- kOpen(session, 57) --------> |   57 > 41: it is the newest now
//    | <------- kOpened(session) ----- |   both start counting at 1
//    | == sequenced frames both ways, cumulative acknowledgements, go-back-N ==
//    | -- kKeepAlive when idle ------> |   either side: silence of `dead_after` = down
//
// A device whose time is simulated waits for its host (LinkOptions::waits, told in
// kOpened): silence of either side is no lost line there, however long, and only a stream
// that ends is. So no stall of a process costs such a machine a tick.
//
// Frames of another session are dropped: bytes that an earlier host left in the line have
// no effect. A device obeys its newest host only (LineEpoch): an older one is refused,
// and sends nothing more for good once it receives the refusal. The receiver's credit
// (frames it can still take) rides in every frame. Not thread-safe; Poll and Send are
// called from one thread; nothing blocks.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/link/byte_stream.h"
#include "services/platform/link/frame.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::link {

struct LinkOptions {
  std::uint16_t window_frames = 32;            ///< sent and not acknowledged, 1..1024
  std::chrono::milliseconds resend_after{30};  ///< without an acknowledgement
  std::chrono::milliseconds keep_alive{50};    ///< longest silence of our own
  std::chrono::milliseconds dead_after{250};   ///< silence of the peer that means down
  bool waits =
      false;  ///< of a device: its time is simulated, and stops for a silent host
};

enum class Side { kHost, kDevice };

/// The newest host of a device. The device's value lives as long as its power is on, over
/// all links; a host's as long as its process.
struct LineEpoch {
  std::uint64_t number = 0;  ///< device: highest that opened; host: its own, 0: none yet
  bool fenced = false;       ///< of a host: a newer one has the device, for good
};

class ReliableLink {
 public:
  /// `type` is LaserFrame or MotionFrame as a number.
  using Handler = std::function<void(std::uint8_t type, std::span<const std::byte>)>;

  ReliableLink(Side side, std::unique_ptr<ByteStream> stream, SteadyClock clock,
               const LinkOptions& options = {},
               std::shared_ptr<LineEpoch> epoch = std::make_shared<LineEpoch>());
  ~ReliableLink();

  /// Reads, delivers frames in order to `handler`, acknowledges, resends, keeps alive.
  /// kLinkLost when the stream is gone for good.
  Status Poll(const Handler& handler);

  /// True when Send would take a frame: the session is up and the window has room.
  bool CanSend() const;
  /// Queues one frame of at most kMaxPayload bytes; kRefused when CanSend is false.
  Status Send(std::uint8_t type, std::span<const std::byte> payload);

  /// A session is agreed and a valid frame of the peer was received within dead_after.
  bool up() const;
  /// Grows with each new session: code that keeps state about the peer starts over.
  std::uint32_t session() const;
  /// Time since the last valid frame of the peer.
  std::chrono::nanoseconds silence() const;
  int fd() const;
  /// Its stream is connected; no session has to be agreed yet.
  bool connected() const;

  struct Counters {
    std::uint64_t sent_frames = 0, resent_frames = 0, received_frames = 0;
    std::uint64_t dropped_bytes = 0, bad_crc = 0, out_of_order = 0;
  };
  const Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace intaglio::link
