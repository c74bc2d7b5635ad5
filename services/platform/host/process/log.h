#pragma once

// What a service logs: on the standard error stream, and in the file of --log-file. From
// any thread, but not from the path of the ticks.

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace intaglio::host {

enum class LogLevel { kInfo, kWarning, kError };

/// Before the first line. `min_level`: trace, debug, info, warning or error; no file
/// when its name is empty.
void OpenLog(const std::string& service, const std::string& min_level,
             const std::string& file);

void Log(LogLevel level, std::string_view line);

template <typename... Values>
void LogInfo(fmt::format_string<Values...> format, Values&&... values) {
  Log(LogLevel::kInfo, fmt::format(format, std::forward<Values>(values)...));
}

template <typename... Values>
void LogWarning(fmt::format_string<Values...> format, Values&&... values) {
  Log(LogLevel::kWarning, fmt::format(format, std::forward<Values>(values)...));
}

template <typename... Values>
void LogError(fmt::format_string<Values...> format, Values&&... values) {
  Log(LogLevel::kError, fmt::format(format, std::forward<Values>(values)...));
}

}  // namespace intaglio::host
