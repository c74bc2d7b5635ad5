#pragma once

// What a check of a job or a machine finds, for a test that expects it.

#include <gmock/gmock.h>

#include <string>

#include "engrave/core/result.h"

namespace intaglio {

/// An error about the field at `path` that contains `what`.
inline auto IsFinding(const std::string& path, const std::string& what) {
  return testing::Field(&Error::message, testing::AllOf(testing::StartsWith(path + ": "),
                                                        testing::HasSubstr(what)));
}

}  // namespace intaglio
