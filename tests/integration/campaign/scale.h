#pragma once

// What a shop of so many idle virtual machines costs (docs/scale.md): each number of
// cells gets a shop of its own by `intaglio up --cells N --virtual`, in the network of
// this program, and a row of a table.
//
// processes, threads, PSS (each shared page divided by the processes that have it, MB)
// and cores (processor seconds a second) are those of `up`, the services and the virtual
// engravers. Packets are those of the loopback interface, over 10 s from 5 s after the
// shop was open on. A sample's age is the time from its write to its receipt by a client
// that follows all cells, for the interlocks (reliable, 20 Hz) and the state of the
// stages (best effort). Times of commands are medians of five.

#include <string>
#include <vector>

namespace intaglio::campaign {

/// Prints the table. `counts`: as they were typed; none: 1, 3 and 10. The exit code of
/// the program: 0, or 1 when a machine was not found, or a process was left behind.
/// 2: a count is not within 1..100.
int RunScale(const std::vector<std::string>& counts);

}  // namespace intaglio::campaign
