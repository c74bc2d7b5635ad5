#pragma once

// bin/virtual-engraver as a process, its panel, and a host at its lines.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "services/platform/link/line_session.h"
#include "tests/integration/run_program.h"
#include "tests/services/virtual_engraver/machine_bench.h"

namespace intaglio::virtual_engraver {

/// The engraver; killed with its holder. Warm at once, no lag, no refraction.
class EngraverProcess {
 public:
  /// Its lines, panel, record and truth file lie in `folder`; over TCP it chooses free
  /// ports. What `truth`, the text of a truth file, sets replaces what it is otherwise; a
  /// text that is no truth is its truth file as it is.
  explicit EngraverProcess(const std::filesystem::path& folder,
                           const std::string& truth = {},
                           const std::vector<std::string>& more_options = {},
                           bool over_tcp = false);

  /// What a host has to open; after AwaitReady.
  std::string laser_line() const { return DeviceOf("laser"); }
  std::string motion_line() const { return DeviceOf("motion"); }
  std::filesystem::path truth_file() const { return folder_ / "truth.textproto"; }
  std::filesystem::path record_file() const { return folder_ / "glass.rec"; }
  intaglio::testing::Running& program() { return program_; }

  /// False when it is not ready within five seconds.
  bool AwaitReady();
  /// One line for another on the panel; empty when it does not answer within a second.
  std::string Ask(const std::string& command) const;
  /// A value of the panel's status, e.g. "shutters"; empty when there is none.
  std::string StatusOf(const std::string& name) const;

 private:
  std::string DeviceOf(const std::string& line) const;

  std::filesystem::path folder_;
  bool over_tcp_;
  intaglio::testing::Running program_;
};

/// A host at both lines.
class EngravingHost {
 public:
  explicit EngravingHost(const EngraverProcess& engraver);

  /// Both sessions are up and both identities were received.
  bool Connect();
  void Poll();
  /// Polls until the condition holds; false when the time is up first.
  bool Until(const std::function<bool()>& condition,
             std::chrono::milliseconds bound = std::chrono::seconds(5));
  bool Send(link::LaserFrame type, const link::Bytes& payload = {});
  bool Send(link::MotionFrame type, const link::Bytes& payload = {});
  /// The lamp is on, shutter 1 open.
  bool OpenShutterAndLamp();
  /// Asks the laser for its tick.
  std::uint64_t TickNow();
  const Received& received() const { return received_; }

 private:
  link::LineSession laser_, motion_;
  Received received_;
};

/// Another process; killed with its holder or its parent.
class ForkedHost {
 public:
  /// `work` runs in the child, which never returns from here.
  explicit ForkedHost(const std::function<void()>& work);
  ~ForkedHost();
  ForkedHost(const ForkedHost&) = delete;
  ForkedHost& operator=(const ForkedHost&) = delete;
  void Signal(int number) const;

 private:
  pid_t pid_ = -1;
};

}  // namespace intaglio::virtual_engraver
