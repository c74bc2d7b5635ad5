#pragma once

// The largest memory of the process while something is done, as the kernel counts it.

#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>

#include "services/platform/host/process/freed_memory.h"

namespace intaglio::test {

namespace internal {

/// A line of /proc/self/status, bytes.
inline std::optional<std::uint64_t> StatusBytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kilobytes = 0;
    if (word == name && status >> kilobytes) return kilobytes << 10;
  }
  return std::nullopt;
}

}  // namespace internal

/// Bytes that the process had at most during `work` beyond those from before. Nothing
/// where the kernel does not count anew, or a sanitizer keeps what is freed.
inline std::optional<std::uint64_t> PeakBytesOf(const std::function<void()>& work) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  work();
  return std::nullopt;
#else
  host::ReturnFreedMemory();
  std::ofstream refs("/proc/self/clear_refs");
  refs << "5" << std::flush;  // VmHWM begins with the present size (proc(5))
  const auto before = internal::StatusBytes("VmHWM:");
  work();
  const auto peak = internal::StatusBytes("VmHWM:");
  if (!refs || !before || !peak) return std::nullopt;
  return *peak - *before;
#endif
}

}  // namespace intaglio::test
