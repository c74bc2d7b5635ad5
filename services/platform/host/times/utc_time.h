#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace intaglio::host {

/// "2026-11-21T15:28:49.123Z", as SQLite's strftime('%Y-%m-%dT%H:%M:%fZ') writes it:
/// texts of it compare as the times do.
std::string UtcText(std::chrono::system_clock::time_point time);

/// Whether each letter of `text` is what a text of UtcText has in its place, from the
/// year on: "2026-11-21", "2026-11-21T15:30" and "2026-11-21T15:28:49.123" are.
bool HasShapeOfUtc(std::string_view text);

/// The time of such a text; nullopt: it is none.
std::optional<std::chrono::system_clock::time_point> TimeOfUtc(const std::string& text);

}  // namespace intaglio::host
