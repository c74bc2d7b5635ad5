#pragma once

// Runs a command of `intaglio` beside this program to its end. What a stranger's file may
// cost, in memory or by a fault of its reader, it costs that process.

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/console.pb.h"

namespace intaglio::console {

struct ProgramEnd {
  int exit_code = 0;              ///< services/client/exit_codes.h
  std::vector<std::string> json;  ///< the lines that are objects of JSON
  std::string text;               ///< the others, for people, without "intaglio: "
};

/// Waits for it. `scratch`: a folder for its output, which is removed. kTimedOut: it was
/// ended; kNotFound, kIo, kTooLarge (its output).
Result<ProgramEnd> RunIntaglio(std::vector<std::string> words,
                               const std::filesystem::path& scratch,
                               std::chrono::milliseconds timeout);

/// Why it did not do what it was called for, with the code: by its CommandAnswer or its
/// event `refused`, else what it printed for people.
ConsoleError RefusalOf(const ProgramEnd& end);

/// The same from the text that it printed.
ProgramEnd EndOfProgram(int exit_code, const std::string& output);

}  // namespace intaglio::console
