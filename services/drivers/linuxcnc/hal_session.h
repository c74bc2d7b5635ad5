#pragma once

// A session with LinuxCNC's HAL: from the first answer to our commands until the line is
// lost. Sends the heartbeat, keeps what is commanded, and reads the samples.
//
//   kClosed --identity, programs started--> kOpening --our command in a sample,--> kUp
//      ^                                       |       record of pulses whole       |
//      +------- no sample for 250 ms, HAL gone, samples missing -------------------+
//
// Numbers of commands begin at the time of day in ms, so a newer host's are higher: a
// sample with a higher one than our newest is another host's (fenced, for good).

#include <chrono>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "services/drivers/linuxcnc/hal_line.h"
#include "services/drivers/linuxcnc/hal_text.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class HalSession {
 public:
  /// `folder`: of deploy/linuxcnc/start. A HAL with another laser is refused.
  HalSession(HalOpener open, std::filesystem::path folder, link::ExpectedDevice expected,
             link::SteadyClock clock, HalLaser laser = HalLaser::kPulses);

  /// The samples that came, in order; empty while not up.
  const std::vector<HalSample>& Poll();
  /// Ends the session; the next one begins by itself.
  void Lose(std::string why);

  bool up() const { return phase_ == Phase::kUp; }
  bool fenced() const { return fenced_; }
  std::uint64_t sessions() const { return sessions_; }
  const std::string& message() const { return message_; }
  const std::string& refusal() const { return refusal_; }
  int fd() const { return line_ ? line_->fd() : -1; }
  const HalIdentity& identity() const { return identity_; }
  const HalSample& newest() const { return newest_; }
  /// Ticks of all pulses before this session, since power-up; of a beam none.
  const std::vector<std::uint32_t>& record() const { return record_; }

  // Commands; kLinkLost while not up. Numbers of the rows that are obeyed:
  std::uint64_t arm() const { return command_.arm; }
  std::uint64_t motion() const { return command_.motion; }
  /// Of the newest command; a sample that has it was made after it.
  std::uint64_t number() const { return command_.number; }
  Status NextArm();
  Status NextMotion();
  Status SetStop(bool on);
  Status SetShutter(bool open);
  Status SetLamp(bool on);
  /// Kept by HAL, for the next host.
  Status SetPeriods(std::uint32_t periods);
  /// Closes the shutter before.
  Status ResetLaser();
  Status ResetMotion();
  Status ResetBoth();
  /// Of a beam: HAL counts 250 ms from here, in which it may be on.
  Status MakePermission();
  Status WriteRows(std::string_view rows);
  bool stopped() const { return command_.stop; }

 private:
  enum class Phase { kClosed, kOpening, kUp };
  void Open(std::chrono::nanoseconds now);
  void Read(std::chrono::nanoseconds now);
  void Receive(const HalSample& sample);
  void Begin();
  void Hello();
  bool RecordIsWhole();
  Status Send();
  Status Reset(std::initializer_list<bool HalCommand::*> latches);
  std::string WhyRefused(const HalIdentity& identity) const;

  HalOpener open_;
  std::filesystem::path folder_;
  link::ExpectedDevice expected_;
  link::SteadyClock clock_;
  HalLaser laser_;
  Phase phase_ = Phase::kClosed;
  bool fenced_ = false, greeted_ = false;
  std::uint64_t sessions_ = 0, first_number_ = 0;
  std::string message_ = "the line is not open yet", refusal_, partial_;
  std::unique_ptr<HalLine> line_;
  HalIdentity identity_;
  HalSample newest_;
  bool has_sample_ = false;
  HalCommand command_;
  std::chrono::nanoseconds next_open_{0}, sampled_at_{0}, beaten_at_{0}, opened_at_{0};
  std::vector<HalSample> samples_;
  std::vector<std::uint32_t> record_;
};

}  // namespace intaglio::drivers
