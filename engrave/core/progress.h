#pragma once

// How a long computation reports its progress, independent of the receiver.

#include <cstdint>
#include <functional>

namespace intaglio {

/// Called now and then from the thread that computes, with the units done so far
/// and their total (0 when unknown). Returns false to ask for an early end: the
/// computation then fails with ErrorCode::kCancelled.
using ProgressSink = std::function<bool(std::uint64_t done, std::uint64_t total)>;

}  // namespace intaglio
