#pragma once

// What a user, a file, a peer or a machine can cause is a Result<T>, never an
// exception: a code to branch on, a sentence a person can act on, and the value
// that was refused. Broken preconditions of our own code throw instead: check.h.

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace intaglio {

enum class ErrorCode {
  kInvalidValue,  ///< A field or an argument has a value outside its range.
  kMissing,       ///< A required field or argument is not there.
  kNotFound,      ///< A file, a glass or a job of that name does not exist.
  kUnreadable,    ///< The file or message is not of the format it should be.
  kUnsupported,   ///< Well formed, but of a kind that is not handled.
  kOutsideBlock,  ///< Points lie outside the block minus its margin.
  kTooLarge,      ///< A limit on size, count or memory is exceeded.
  kIo,            ///< The operating system refused to read or write.
  kLinkLost,      ///< A serial line or a peer is lost.
  kTimedOut,      ///< An answer did not come in time.
  kRefused,       ///< A peer or an interlock refused.
  kFault,         ///< A machine reported a fault.
  kCancelled,     ///< The caller requested the cancellation.
};

/// The name of a code as it appears in reports and logs, e.g. "invalid_value".
const char* ErrorCodeName(ErrorCode code);

struct Error {
  ErrorCode code = ErrorCode::kInvalidValue;
  /// One sentence: what is wrong, where (file or field), and the remedy.
  std::string message;
  /// The offending value as text; may be empty.
  std::string value;
};

template <typename T>
using Result = tl::expected<T, Error>;

/// Result of a function that returns no value.
using Status = tl::expected<void, Error>;

inline tl::unexpected<Error> Fail(ErrorCode code, std::string message,
                                  std::string value = {}) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(value)});
}

}  // namespace intaglio
