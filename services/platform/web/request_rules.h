#pragma once

// What a request may ask for and from where: its target, and the headers that show
// whether a page of somebody else sent it. Pure functions of texts from the network.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::web {

struct Target {
  std::string path;                          ///< decoded, absolute, without "." and ".."
  std::map<std::string, std::string> query;  ///< decoded; of a repeated name the first
};

/// The target of a request line, e.g. "/api/v1/jobs?from=3". kInvalidValue: it is no
/// absolute path, has a broken escape, a control character, a backslash, or a part "." or
/// ".." even after decoding.
Result<Target> ParseTarget(std::string_view target);

/// By what a server is opened.
struct OwnNames {
  bool is_encrypted = false;
  std::uint16_t port = 0;
  /// Those of its certificate, then those of every computer for itself.
  std::vector<std::string> names = {"127.0.0.1", "localhost", "[::1]"};
};

/// "http://127.0.0.1", by the first name.
std::string OriginOf(const OwnNames& own);

/// One of the names with the port, which may be left out where it is the scheme's. A page
/// of another name that was made to point to this computer (DNS rebinding) has another
/// Host.
bool IsOwnHost(std::string_view host, const OwnNames& own);

/// The scheme and an own host: a page of this server.
bool IsOwnOrigin(std::string_view origin, const OwnNames& own);

/// The value of a cookie in a Cookie header; empty when it is not there.
std::string_view CookieIn(std::string_view header, std::string_view name);

/// The key of "Bearer KEY"; empty when the header has another form.
std::string_view BearerKeyIn(std::string_view authorization);

/// In a time that depends on the lengths alone.
bool IsSameKey(std::string_view a, std::string_view b);

}  // namespace intaglio::web
