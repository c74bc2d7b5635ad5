#pragma once

// How many files a program may still open. The DDS library ends with SIGSEGV when it gets
// no descriptor for its sockets, and other libraries report a file that cannot be opened
// and not why: so each program checks the limit before it does anything.

#include <cstddef>

#include "engrave/core/result.h"

namespace intaglio::command_line {

/// Descriptors that every program of the product gets along with: three times what one
/// with both DDS domains, two lines, a queue and its logs has open.
inline constexpr std::size_t kMinFreeDescriptors = 100;

/// Raises the soft limit of this process, when it is too low, as far as the system
/// permits it; kRefused, with the limit and how to raise it, when fewer than
/// kMinFreeDescriptors can be opened even then.
Status CheckOpenFiles();

}  // namespace intaglio::command_line
