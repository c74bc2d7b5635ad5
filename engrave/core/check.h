#pragma once

// Preconditions of our own code. They are always on and they throw: a process
// beside a laser must be able to make it safe before it ends, so nothing aborts.

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace intaglio {

/// A broken precondition: a defect of the program, not of its input.
class PreconditionError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws PreconditionError with the formatted text unless `condition` holds.
///   Require(spacing_mm > 0, "spacing_mm must be positive, is {}", spacing_mm);
template <typename... Args>
void Require(bool condition, fmt::format_string<Args...> text, Args&&... args) {
  if (!condition) {
    throw PreconditionError(fmt::format(text, std::forward<Args>(args)...));
  }
}

}  // namespace intaglio
