#pragma once

// Runs a program of the product to its end, bounded in time, and keeps its output.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/own_network.h"
#include "tests/patience.h"

namespace intaglio::testing {

using test::Eventually;

struct Ended {
  int exit_code = -1;  ///< 128 + signal when it was killed
  bool in_time = false;
  std::string output;  ///< stdout and stderr together
  double seconds = 0;
};

/// A program that runs; ended (SIGKILL, by its process id) when this goes.
class Running {
 public:
  Running(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& output_file);
  ~Running();
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  pid_t pid() const { return pid_; }
  bool running();
  void Signal(int number) const;
  Ended WaitForEnd(std::chrono::seconds bound);
  std::string Output() const;

 private:
  std::filesystem::path output_file_;
  std::chrono::steady_clock::time_point began_;
  pid_t pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
};

/// A program beside the product's others, e.g. "intaglio".
std::filesystem::path Program(const std::string& name);
/// Process ids of the programs whose command line contains all of `words`.
std::vector<pid_t> ProcessesWith(const std::vector<std::string>& words);
/// What the panel of the machine in `folder` answers to one line; empty: nothing.
std::string AskPanel(const std::filesystem::path& folder, const std::string& command);
/// A whole file; empty when it cannot be read.
std::string TextIn(const std::filesystem::path& file);

}  // namespace intaglio::testing
