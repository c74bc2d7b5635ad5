#pragma once

// The allowed ranges of numbers in job.proto, course.proto and machine.proto: those of
// the methods come from their table (methods/method_table.h), all others are listed here.
// The comments in the schemas state the same ranges; tests/services/job compares them.

#include <google/protobuf/message.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/result.h"
#include "services/job/findings.h"

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

/// One for each number of `message`, at any depth, that is outside its range. Paths start
/// with `path`. Fields with presence are skipped when absent; the others are always
/// checked, so that a forgotten one shows as 0.
std::vector<Finding> OutOfRange(const google::protobuf::Message& message,
                                const std::string& path);

/// Appends the fields out of range. Found: Finding, or Error for a caller that needs no
/// field.
template <typename Found>
void CheckRanges(const google::protobuf::Message& message, const std::string& path,
                 std::vector<Found>& errors) {
  for (Finding& found : OutOfRange(message, path)) errors.push_back(std::move(found));
}

/// "a.b", or "b" when a is empty.
std::string JoinPath(std::string_view path, std::string_view field);

}  // namespace intaglio
