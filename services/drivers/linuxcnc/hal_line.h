#pragma once

// The line to LinuxCNC's realtime HAL with the configuration of deploy/linuxcnc: text out
// to its two streams, rows and commands, and text in from its sampler. The programs
// halstreamer and halsampler of LinuxCNC are started for it: their licence is the GPL, so
// nothing of LinuxCNC is linked.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio::drivers {

class HalLine {
 public:
  virtual ~HalLine() = default;
  /// Whole lines, all or nothing; kLinkLost when they are not taken at once. Never
  /// blocks.
  virtual Status WriteRows(std::string_view lines) = 0;
  virtual Status WriteCommands(std::string_view lines) = 0;
  /// Bytes read into `buffer`; 0 when there are none; kLinkLost when the sampler is gone.
  virtual Result<std::size_t> ReadSamples(std::span<char> buffer) = 0;
  /// Of the samples, for poll(2); -1: none.
  virtual int fd() const = 0;
};

using HalOpener = std::function<Result<std::unique_ptr<HalLine>>()>;

/// Starts the programs; kIo with the remedy when they are not there. They end with this
/// object, and with this process however it ends.
Result<std::unique_ptr<HalLine>> OpenHalLine();

}  // namespace intaglio::drivers
