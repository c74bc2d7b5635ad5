#pragma once

// LinuxCNC's realtime HAL with the supplied configuration (deploy/linuxcnc), simulated
// axes, for tests. One instance a System V IPC namespace: EnterNamespace gives this
// process, and what it starts, one of its own.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::linuxcnc {

/// Why HAL cannot run here, in a sentence; empty: it can, and this process has a new IPC
/// namespace of its own and, where it may, a place before the processes that are
/// scheduled as usual. Before the first thread.
std::string EnterNamespace();

/// A program of HAL's, halstreamer or halsampler; killed in the end.
class HalTool {
 public:
  /// Its output is appended to the file `output`.
  HalTool(const std::vector<std::string>& arguments, const std::string& output);
  ~HalTool();
  HalTool(const HalTool&) = delete;
  HalTool& operator=(const HalTool&) = delete;
  void Write(const std::string& text) const;

 private:
  pid_t child_ = -1;
  int input_ = -1;
};

class HalMachine {
 public:
  /// Starts it; throws std::runtime_error with HAL's output when it does not run. `axes`:
  /// the axes' own HAL file; empty: the supplied one without hardware. `beam`: with a
  /// beam in place of pulses.
  explicit HalMachine(std::filesystem::path folder, std::string serial_number = "",
                      std::filesystem::path axes = {}, bool beam = false);
  ~HalMachine();
  HalMachine(const HalMachine&) = delete;
  HalMachine& operator=(const HalMachine&) = delete;

  /// A command of halcmd, e.g. "sets key-on 0".
  void Command(const std::string& command);
  /// What halcmd reads from a pin, e.g. "pulse-count.count".
  double ValueOf(const std::string& pin);
  void PowerOff();
  void PowerOn();
  const std::filesystem::path& folder() const { return folder_; }
  /// Ticks of the pulses that HAL has recorded since power-up, in order.
  std::vector<std::uint64_t> RecordedTicks() const;

 private:
  std::filesystem::path folder_;
  std::string serial_number_;
  std::filesystem::path axes_;
  bool beam_;
  pid_t child_ = -1;
  int input_ = -1;
};

}  // namespace intaglio::linuxcnc
