#pragma once

// Files of strangers are read by a process of their own: a file that is damaged, or made
// to harm, may crash its reader, fill the memory or be read for ever. In that case only
// this process ends, and the error names the file; a service or a command goes on.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::reading {

struct FileProcess {
  std::vector<std::string> words;  ///< the program and its arguments
  std::chrono::seconds time{20};   ///< of the processor
  std::uint64_t memory_bytes = 0;  ///< of its addresses, with its libraries
};

struct ProcessEnd {
  int exit_code = -1;  ///< -1: a signal has ended it
  bool is_too_long = false;
  std::string reason;  ///< "Segmentation fault", "exit code 3"
  std::vector<std::byte> output;
};

/// Runs the process with the file as its standard input until its end; what it writes to
/// its standard output is the answer. kNotFound: the program cannot be started; kIo.
/// `name`: of the file, for errors. Of any thread.
Result<ProcessEnd> RunOnFile(FileProcess process, std::span<const std::byte> file,
                             std::string_view name);

}  // namespace intaglio::reading
