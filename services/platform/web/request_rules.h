#pragma once

// What a request may ask for and from where: its target, and the headers that show
// whether a page of somebody else sent it. Pure functions of texts from the network.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

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

/// "127.0.0.1", "localhost" or "[::1]" with this port. A page of another name that was
/// made to point to this computer (DNS rebinding) has another Host.
bool IsOwnHost(std::string_view host, std::uint16_t port);

/// "http://" and an own host: a page of this server.
bool IsOwnOrigin(std::string_view origin, std::uint16_t port);

/// The value of a cookie in a Cookie header; empty when it is not there.
std::string_view CookieIn(std::string_view header, std::string_view name);

/// The key of "Bearer KEY"; empty when the header has another form.
std::string_view BearerKeyIn(std::string_view authorization);

/// In a time that depends on the lengths alone.
bool IsSameKey(std::string_view a, std::string_view b);

}  // namespace intaglio::web
