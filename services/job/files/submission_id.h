#pragma once

// The submission_uid of a JobSubmission: "key:KEY:CHECKSUM". Whoever submits the same job
// with the same key again submits nothing: there is one answer for each key.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio {

/// kInvalidValue unless it is 1 to 64 letters, digits, '.', '_' and '-'.
Status CheckSubmissionKey(std::string_view key);

/// `job`: the serialized JobSpec.
std::string SubmissionUid(std::string_view key, std::span<const std::uint8_t> job);

/// Of a uid that SubmissionUid made; empty: of another one.
std::string_view SubmissionKeyOf(std::string_view uid);

}  // namespace intaglio
