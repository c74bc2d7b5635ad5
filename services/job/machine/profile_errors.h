#pragma once

// Errors of a machine profile: the field, what is wrong, and what to do.

#include <fmt/format.h>

#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

inline void Missing(std::vector<Error>& errors, const std::string& path,
                    const std::string& remedy) {
  errors.push_back(
      {ErrorCode::kMissing, fmt::format("{}: is missing; {}", path, remedy), ""});
}

inline void Wrong(std::vector<Error>& errors, const std::string& path,
                  const std::string& what) {
  errors.push_back({ErrorCode::kInvalidValue, fmt::format("{}: {}", path, what), ""});
}

}  // namespace intaglio
