#pragma once

namespace intaglio::test {

/// How many times as long code may take when sanitizers watch it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSanitizersTake = 20;
#else
inline constexpr int kSanitizersTake = 1;
#endif

}  // namespace intaglio::test
