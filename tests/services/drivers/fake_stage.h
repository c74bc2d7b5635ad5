#pragma once

// A stage controller as its driver sees it: it takes segments into a queue, sends the
// statuses that the test sets, and remembers every command. Behind a pseudo-terminal.

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/platform/link/line_session.h"
#include "services/platform/link/motion_protocol.h"
#include "services/virtual_engraver/lines/pty_line.h"

namespace intaglio::drivers {

class FakeStage {
 public:
  FakeStage(std::filesystem::path device, std::uint32_t queue_capacity)
      : device_(std::move(device)), capacity_(queue_capacity) {
    Plug();
  }

  void Plug() {
    line_ = virtual_engraver::PtyLine::Open(device_, "fake stage").value();
    link_ = std::make_unique<link::ReliableLink>(link::Side::kDevice, line_->MachineEnd(),
                                                 link::MonotonicClock());
    session_ = 0;
  }
  void Unplug() {
    link_.reset();
    line_.reset();
  }

  void Poll() {
    if (!link_) return;
    const auto polled =
        link_->Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
          Receive(static_cast<link::MotionFrame>(type), payload);
        });
    ASSERT_TRUE(polled.has_value());
    if (!link_->up() || link_->session() == session_) return;
    session_ = link_->session();
    link::MotionIdentity identity;
    identity.queue_capacity = capacity_;
    identity.serial_number = serial_number;
    identity.velocity_unit_nm_s = velocity_unit_nm_s;
    Send(link::MotionFrame::kMotionIdentity, Encode(identity));
    if (clock != 0) {
      Send(link::MotionFrame::kControllerClock, Encode(link::ControllerClock{clock, 1}));
    }
  }

  /// Content of the next statuses besides the queue.
  link::MotionStatus status;
  bool answers_status = true;
  std::string serial_number = "S-03";  ///< reported at the next handshakes
  std::uint32_t clock = 0;             ///< of its own; 0: none
  std::uint32_t velocity_unit_nm_s = 1;
  void SendStatus() {
    status.queue_free = capacity_ - static_cast<std::uint32_t>(queue.size());
    status.segments_taken = taken_;
    Send(link::MotionFrame::kMotionStatus, Encode(status));
  }
  void Send(link::MotionFrame type, const link::Bytes& payload) {
    // A full window only means that this message is not sent; statuses come again.
    (void)link_->Send(static_cast<std::uint8_t>(type), payload);
  }

  std::vector<link::BeginRun> begun;
  std::vector<link::BeginTimedRun> timed_begun;
  std::vector<link::WireTimedSegment> timed_segments;
  std::deque<link::WireSegment> queue;  ///< not executed yet
  std::vector<link::WireSegment> all_segments;
  int aborts = 0, resets = 0;
  bool overflowed = false;
  bool out_of_order = false;

 private:
  void Receive(link::MotionFrame type, std::span<const std::byte> payload) {
    using link::MotionFrame;
    if (type == MotionFrame::kBeginRun) {
      begun.push_back(link::Decode<link::BeginRun>(payload).value());
      status.run = begun.back().run;
      taken_ = 0;
      queue.clear();
    } else if (type == MotionFrame::kSegments) {
      TakeSegments(link::Decode<link::Segments>(payload).value());
    } else if (type == MotionFrame::kBeginTimedRun) {
      timed_begun.push_back(link::Decode<link::BeginTimedRun>(payload).value());
      status.run = timed_begun.back().run;
      taken_ = 0;
    } else if (type == MotionFrame::kTimedSegments) {
      const auto frame = link::Decode<link::TimedSegments>(payload).value();
      out_of_order =
          out_of_order || frame.run != status.run || frame.first_number != taken_;
      taken_ += frame.segments.size();
      timed_segments.insert(timed_segments.end(), frame.segments.begin(),
                            frame.segments.end());
    } else if (type == MotionFrame::kAbortRun) {
      ++aborts;
    } else if (type == MotionFrame::kMotionReset) {
      ++resets;
    } else if (type == MotionFrame::kMotionStatusRequest && answers_status) {
      SendStatus();
    }
  }
  void TakeSegments(const link::Segments& frame) {
    out_of_order =
        out_of_order || frame.run != status.run || frame.first_number != taken_;
    taken_ += frame.segments.size();
    queue.insert(queue.end(), frame.segments.begin(), frame.segments.end());
    all_segments.insert(all_segments.end(), frame.segments.begin(), frame.segments.end());
    overflowed = overflowed || queue.size() > capacity_;
  }

  std::filesystem::path device_;
  std::uint32_t capacity_;
  std::optional<virtual_engraver::PtyLine> line_;
  std::unique_ptr<link::ReliableLink> link_;
  std::uint32_t session_ = 0;
  std::uint64_t taken_ = 0;
};

}  // namespace intaglio::drivers
