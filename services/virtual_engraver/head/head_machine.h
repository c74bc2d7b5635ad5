#pragma once

// A scan head as a machine behind one line: controller, record of the burnt material, and
// the clock that drives them. One thread; time comes from an injected clock.
//
// Lockstep: ticks pass as fast as blocks come. Real time: by the clock.

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <tuple>

#include "services/virtual_engraver/head/head_controller.h"
#include "services/virtual_engraver/lines/device_line.h"

namespace intaglio::virtual_engraver {

class HeadMachine {
 public:
  /// Begins the record file anew. kIo when it cannot be written.
  static Result<std::unique_ptr<HeadMachine>> Make(const HeadOptions& options,
                                                   const std::filesystem::path& record,
                                                   link::SteadyClock clock);

  /// The line is plugged in: the machine's end of it. Null unplugs it.
  void Plug(std::unique_ptr<link::ByteStream> end);
  /// Line, ticks that are due, reports. Returns how long nothing is due.
  std::chrono::nanoseconds Turn();
  /// What was burnt is on disk. kIo when the disk refuses.
  Status Flush();

  HeadController& controller() { return controller_; }
  std::uint64_t burnt_ticks() const { return burnt_ticks_; }
  /// One line of JSON.
  std::string StatusLine() const;

 private:
  HeadMachine(const HeadOptions& options, std::ofstream record, link::SteadyClock clock);
  void Handle(link::HeadFrame type, std::span<const std::byte> payload);
  void PollLine();
  void PassTicks();
  void SendReports();

  bool lockstep_;
  std::ofstream record_;
  std::vector<std::byte> unwritten_;
  std::uint64_t burnt_ticks_ = 0;
  link::SteadyClock clock_;
  std::chrono::nanoseconds begun_at_;
  std::uint64_t passed_ticks_ = 0;
  HeadController controller_;
  DeviceLine line_;
  std::tuple<std::uint32_t, link::HeadRunState, std::uint32_t, int> sent_state_{};
};

}  // namespace intaglio::virtual_engraver
