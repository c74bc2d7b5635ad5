#pragma once

// What a check of a message finds, each with the path of the field.

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

struct Finding : Error {
  /// Implicit: an error by itself is a finding of no field.
  Finding(Error error, std::string field_path = {})
      : Error(std::move(error)), field(std::move(field_path)) {}

  std::string field;  ///< its path, "models[0].file"; empty: of no field
};

/// Whether it is about this field or one within it: "models" and "models[0].file".
inline bool Concerns(const Finding& finding, std::string_view field) {
  if (!finding.field.starts_with(field)) return false;
  const auto rest = std::string_view(finding.field).substr(field.size());
  return rest.empty() || rest.front() == '.' || rest.front() == '[';
}

class Findings {
 public:
  template <typename... Args>
  void Missing(const std::string& path, fmt::format_string<Args...> remedy,
               Args&&... args) {
    found_.push_back({{ErrorCode::kMissing,
                       fmt::format("{}: is missing; {}", path,
                                   fmt::format(remedy, std::forward<Args>(args)...)),
                       ""},
                      path});
  }

  /// `path: value what`
  template <typename Value, typename... Args>
  void Wrong(const std::string& path, const Value& value,
             fmt::format_string<Args...> what, Args&&... args) {
    const std::string text = fmt::format("{}", value);
    found_.push_back({{ErrorCode::kInvalidValue,
                       fmt::format("{}: {} {}", path, text,
                                   fmt::format(what, std::forward<Args>(args)...)),
                       text},
                      path});
  }

  std::vector<Finding>& found() { return found_; }

 private:
  std::vector<Finding> found_;
};

}  // namespace intaglio
