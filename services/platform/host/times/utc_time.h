#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace intaglio::host {

/// "2026-11-21T15:28:49.123Z", as SQLite's strftime('%Y-%m-%dT%H:%M:%fZ') writes it:
/// texts of it compare as the times do.
std::string UtcText(std::chrono::system_clock::time_point time);

/// The time of such a text; nullopt: it is none.
std::optional<std::chrono::system_clock::time_point> TimeOfUtc(const std::string& text);

}  // namespace intaglio::host
