#pragma once

// ErrorCode as it travels in a TaskStatus (idl/job.idl), which has a code for "no error".

#include "engrave/core/result.h"
#include "idl/job.h"

namespace intaglio::bus {

/// The wire has the codes in the same order, behind ERROR_NONE.
constexpr intaglio_ErrorCode WireOf(ErrorCode code) {
  return static_cast<intaglio_ErrorCode>(static_cast<int>(code) + 1);
}
static_assert(WireOf(ErrorCode::kInvalidValue) == intaglio_ERROR_INVALID_VALUE);
static_assert(WireOf(ErrorCode::kCancelled) == intaglio_ERROR_CANCELLED);

/// As ErrorCodeName; empty for ERROR_NONE.
inline const char* NameOf(intaglio_ErrorCode code) {
  if (code == intaglio_ERROR_NONE) return "";
  return ErrorCodeName(static_cast<ErrorCode>(static_cast<int>(code) - 1));
}

}  // namespace intaglio::bus
