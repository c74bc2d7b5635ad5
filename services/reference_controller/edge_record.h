#pragma once

// The edges of simulated outputs in a file, and how exact their times are.

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/result.h"
#include "services/reference_controller/recorded_outputs.h"

namespace intaglio::reference_controller {

/// Signals by the names of their fields in a board file: "q_switch", "shutters[0]".
std::string NameOf(Output output);

/// CSV with the columns ns, output, on (1 or 0). Each line is in the file before the
/// next edge.
class EdgeRecord {
 public:
  /// Replaces the file. kIo.
  static Result<EdgeRecord> Create(const std::filesystem::path& file);
  void Add(const Edge& edge);

 private:
  std::ofstream stream_;
};

/// Times that should all be the same.
struct Spread {
  std::size_t count = 0;
  double mean_us = 0, deviation_us = 0;  ///< root of the mean square from the mean
  double min_us = 0, p999_us = 0, max_us = 0;
};
/// There is one time at least.
Spread SpreadOf(std::vector<double> times_us);
/// A table with a line of names, and one of each spread, that end with '\n'.
std::string TextOfSpreads(const std::vector<std::pair<const char*, Spread>>& spreads);

struct Jitter {
  Spread period;             ///< from a lamp trigger to the next
  Spread delay;              ///< from a lamp trigger to its trigger of the Q-switch
  Spread width;              ///< of the trigger
  std::size_t withheld = 0;  ///< lamp triggers without one
};
/// `edges`: in the order of time, with 2 lamp triggers and a trigger at least.
Jitter JitterOf(const std::vector<Edge>& edges);
/// A table of lines that end with '\n'.
std::string ToText(const Jitter& jitter);

}  // namespace intaglio::reference_controller
