#pragma once

// What a check of a message finds, each with the path of the field.

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

class Findings {
 public:
  template <typename... Args>
  void Missing(const std::string& path, fmt::format_string<Args...> remedy,
               Args&&... args) {
    errors_.push_back({ErrorCode::kMissing,
                       fmt::format("{}: is missing; {}", path,
                                   fmt::format(remedy, std::forward<Args>(args)...)),
                       ""});
  }

  /// `path: value what`
  template <typename Value, typename... Args>
  void Wrong(const std::string& path, const Value& value,
             fmt::format_string<Args...> what, Args&&... args) {
    const std::string text = fmt::format("{}", value);
    errors_.push_back({ErrorCode::kInvalidValue,
                       fmt::format("{}: {} {}", path, text,
                                   fmt::format(what, std::forward<Args>(args)...)),
                       text});
  }

  std::vector<Error>& errors() { return errors_; }

 private:
  std::vector<Error> errors_;
};

}  // namespace intaglio
