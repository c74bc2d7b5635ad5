#include "services/platform/web/request_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "engrave/core/try.h"

namespace intaglio::web {
namespace {

std::optional<unsigned> HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

Result<std::string> Decode(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const auto high = i + 2 < text.size() ? HexDigit(text[i + 1]) : std::nullopt;
    const auto low = i + 2 < text.size() ? HexDigit(text[i + 2]) : std::nullopt;
    if (!high || !low)
      return Fail(ErrorCode::kInvalidValue, "the target has a broken % escape");
    decoded += static_cast<char>(*high * 16 + *low);
    i += 2;
  }
  for (const char c : decoded) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == 0x7f)
      return Fail(ErrorCode::kInvalidValue, "the target has a forbidden character");
  }
  return decoded;
}

/// Calls part(text) for each part between separators, until it returns false.
template <typename Part>
void Split(std::string_view text, char separator, const Part& part) {
  for (;;) {
    const auto end = text.find(separator);
    if (!part(text.substr(0, end)) || end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

bool ClimbsUp(std::string_view path) {
  bool climbs = false;
  Split(path, '/', [&](std::string_view part) {
    climbs = part == "." || part == "..";
    return !climbs;
  });
  return climbs;
}

std::string_view SchemeOf(const OwnNames& own) {
  return own.is_encrypted ? "https://" : "http://";
}

}  // namespace

Result<Target> ParseTarget(std::string_view target) {
  const auto question = target.find('?');
  Target parsed;
  auto path = INTAGLIO_TRY(Decode(target.substr(0, question)));
  parsed.path = std::move(path);
  if (!parsed.path.starts_with('/') || ClimbsUp(parsed.path))
    return Fail(ErrorCode::kInvalidValue, "the target is no absolute path");
  if (question == std::string_view::npos) return parsed;
  Status broken;
  Split(target.substr(question + 1), '&', [&](std::string_view pair) {
    const auto equals = pair.find('=');
    auto name = Decode(pair.substr(0, equals));
    auto value = Decode(equals == std::string_view::npos ? "" : pair.substr(equals + 1));
    if (!name || !value) {
      broken = tl::unexpected(name ? value.error() : name.error());
      return false;
    }
    parsed.query.try_emplace(std::move(*name), std::move(*value));
    return true;
  });
  INTAGLIO_TRY(broken);
  return parsed;
}

std::string OriginOf(const OwnNames& own) {
  return fmt::format("{}{}", SchemeOf(own), own.names.front());
}

bool IsOwnHost(std::string_view host, const OwnNames& own) {
  const bool usual = own.port == (own.is_encrypted ? 443 : 80);
  return std::any_of(own.names.begin(), own.names.end(), [&](const std::string& name) {
    return host == fmt::format("{}:{}", name, own.port) || (usual && host == name);
  });
}

bool IsOwnOrigin(std::string_view origin, const OwnNames& own) {
  const std::string_view scheme = SchemeOf(own);
  return origin.starts_with(scheme) && IsOwnHost(origin.substr(scheme.size()), own);
}

std::string_view CookieIn(std::string_view header, std::string_view name) {
  std::string_view found;
  Split(header, ';', [&](std::string_view pair) {
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    const bool is_it =
        pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=';
    if (is_it) found = pair.substr(name.size() + 1);
    return !is_it;
  });
  return found;
}

std::string_view BearerKeyIn(std::string_view authorization) {
  constexpr std::string_view kBearer = "Bearer ";
  return authorization.starts_with(kBearer) ? authorization.substr(kBearer.size())
                                            : std::string_view();
}

bool IsSameKey(std::string_view a, std::string_view b) {
  if (a.size() != b.size() || a.empty()) return false;
  unsigned differences = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differences |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differences == 0;
}

}  // namespace intaglio::web
