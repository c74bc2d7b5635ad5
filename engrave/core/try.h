#pragma once

// Propagates errors: the value of a Result, or the enclosing function returns its error.
//
//   const PointList points = INTAGLIO_TRY(ReadPoints(file));
//   INTAGLIO_TRY(WriteReport(report));            // a Status
//
// Only in a function or lambda that returns a Result or a Status, and only as a whole
// statement or initializer: of a longer expression it is open what else was evaluated.
// A statement expression of GCC and Clang, because an initializer can be `const` so.

#include <type_traits>
#include <utility>

#include "engrave/core/result.h"

namespace intaglio::internal {

/// The value; of a Status nothing.
template <typename T>
T ValueOf(Result<T>&& result) {
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}
template <typename T>
T ValueOf(const Result<T>& result) {
  if constexpr (!std::is_void_v<T>) return *result;
}

}  // namespace intaglio::internal

#define INTAGLIO_TRY_JOINED(a, b) a##b
#define INTAGLIO_TRY_NAME(a, b) INTAGLIO_TRY_JOINED(a, b)
#define INTAGLIO_TRY_OF(name, ...)                                     \
  ({                                                                   \
    auto&& name = (__VA_ARGS__);                                       \
    if (!name) return ::tl::unexpected(std::move(name).error());       \
    ::intaglio::internal::ValueOf(std::forward<decltype(name)>(name)); \
  })
#define INTAGLIO_TRY(...) \
  INTAGLIO_TRY_OF(INTAGLIO_TRY_NAME(try_result_, __COUNTER__), __VA_ARGS__)
