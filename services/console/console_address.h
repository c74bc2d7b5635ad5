#pragma once

// Where a console is and with what key: the address that a person opens, kept in a file
// that its user alone can read, so that a console that is started again has the same one.

#include <cstdint>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::console {

struct ConsoleAddress {
  std::string origin = "http://127.0.0.1";  ///< scheme and name
  std::uint16_t port = 0;
  std::string key;  ///< 64 hex digits; empty: a log-in is needed
};

/// "http://127.0.0.1:PORT/?key=KEY", "https://shop.example:PORT/".
std::string TextOf(const ConsoleAddress& address);
/// kInvalidValue: another text.
Result<ConsoleAddress> ParseAddress(const std::string& text);

/// The first line of the file. kNotFound, kIo, kInvalidValue.
Result<ConsoleAddress> ReadAddressFile(const std::filesystem::path& file);
/// Mode 0600, atomic. kIo.
Status WriteAddressFile(const std::filesystem::path& file, const ConsoleAddress& address);

}  // namespace intaglio::console
