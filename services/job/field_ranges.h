#pragma once

// The allowed ranges of numbers in job.proto and machine.proto: those of the methods come
// from their table (methods/method_table.h), all others are listed here. The comments in
// the schemas say the same; tests/services/job compares them.

#include <google/protobuf/message.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

/// Both ends are allowed; NaN and infinities never are. Of a Vector3 each component, of a
/// repeated field each element.
struct FieldRange {
  std::string_view message;  ///< e.g. "Block"
  std::string_view field;
  double min = 0;
  double max = 0;
};

std::span<const FieldRange> FieldRanges();

/// nullptr when the field has no range.
const FieldRange* FindRange(std::string_view message, std::string_view field);

/// Appends one error for each number of `message`, at any depth, that is outside its
/// range. Paths start with `path`. Fields that tell presence are passed over when absent;
/// the others are always looked at, so that a forgotten one shows as 0.
void CheckRanges(const google::protobuf::Message& message, const std::string& path,
                 std::vector<Error>& errors);

/// "a.b", or "b" when a is empty.
std::string JoinPath(std::string_view path, std::string_view field);

}  // namespace intaglio
