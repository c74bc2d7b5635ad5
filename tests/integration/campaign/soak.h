#pragma once

// Job after job in one shop in lockstep, each disturbed once, over many hours of the
// machine's own time: at 1 Hz a tick of the lamp is a second. What must not grow from the
// second third of the hours to the last one: threads, descriptors and memory of each
// service (memory by more than an allocator keeps in reserve), and the files of the shop
// beside those of its jobs. In every job each point is made once, at the tick that the
// journal has for it, and ticks ascend over all jobs.

namespace intaglio::campaign {

struct SoakOptions {
  double hours = 1;  ///< of engraving, above 0
  unsigned seed = 1;
};

/// Prints a table. The exit code of the program: 0, or 1 when something grew, or a job
/// did not end as it should; three of these end the soak.
int RunSoak(const SoakOptions& options);

}  // namespace intaglio::campaign
