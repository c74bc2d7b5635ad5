#pragma once

// How a parallel algorithm gets its workers without choosing threads itself.

#include <cstddef>
#include <functional>

namespace intaglio {

/// Calls work(0) .. work(count - 1), each once, in any order and on any threads, and
/// returns when all are done; rethrows an exception of one of them. Results must not
/// depend on which thread does what.
using Executor =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& work)>;

/// Runs the tasks one after another in the calling thread. An empty Executor has the same
/// effect.
inline void RunEach(const Executor& executor, std::size_t count,
                    const std::function<void(std::size_t)>& work) {
  if (executor) return executor(count, work);
  for (std::size_t i = 0; i < count; ++i) work(i);
}

}  // namespace intaglio
