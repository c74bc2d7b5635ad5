#pragma once

#include <cstddef>

namespace intaglio::test {

/// How many times as long code may take when sanitizers watch it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSanitizersTake = 20;
#else
inline constexpr int kSanitizersTake = 1;
#endif

/// Bytes that were freed and still occupy memory: the quarantine of the address
/// sanitizer, which finds their later use.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr std::size_t kQuarantineBytes = std::size_t{256} << 20;
#else
inline constexpr std::size_t kQuarantineBytes = 0;
#endif

}  // namespace intaglio::test
