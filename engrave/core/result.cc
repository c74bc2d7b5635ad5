#include "engrave/core/result.h"

namespace intaglio {

const char* ErrorCodeName(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidValue:
      return "invalid_value";
    case ErrorCode::kMissing:
      return "missing";
    case ErrorCode::kNotFound:
      return "not_found";
    case ErrorCode::kUnreadable:
      return "unreadable";
    case ErrorCode::kUnsupported:
      return "unsupported";
    case ErrorCode::kOutsideBlock:
      return "outside_block";
    case ErrorCode::kTooLarge:
      return "too_large";
    case ErrorCode::kIo:
      return "io";
    case ErrorCode::kLinkLost:
      return "link_lost";
    case ErrorCode::kTimedOut:
      return "timed_out";
    case ErrorCode::kRefused:
      return "refused";
    case ErrorCode::kFault:
      return "fault";
    case ErrorCode::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace intaglio
