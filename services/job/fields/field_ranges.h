#pragma once

// What is outside the ranges of its fields (services/platform/fields), as findings.

#include <google/protobuf/message.h>

#include <string>
#include <utility>
#include <vector>

#include "services/job/fields/findings.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {

/// One for each number of `message`, at any depth, that is outside its range. Paths start
/// with `path`.
std::vector<Finding> OutOfRange(const google::protobuf::Message& message,
                                const std::string& path);

/// Appends the fields out of range. Found: Finding, or Error for a caller that needs no
/// field.
template <typename Found>
void CheckRanges(const google::protobuf::Message& message, const std::string& path,
                 std::vector<Found>& errors) {
  for (Finding& found : OutOfRange(message, path)) errors.push_back(std::move(found));
}

}  // namespace intaglio
