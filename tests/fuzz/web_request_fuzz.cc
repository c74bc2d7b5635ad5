// Any text as a target and as the headers that are checked: what is accepted is a path
// that does not climb, and an own host has the port. As a file of users: what is read is
// written and read again as the same.

#include <cstdint>
#include <string>

#include "engrave/core/check.h"
#include "services/platform/access/users.h"
#include "services/platform/web/request_rules.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const web::OwnNames own{.port = 8850};
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  if (const auto target = web::ParseTarget(text)) {
    Require(target->path.starts_with('/'), "no absolute path");
    const std::string path = target->path + "/";
    Require(path.find("/../") == std::string::npos, "a path that climbs");
    Require(path.find('\\') == std::string::npos, "a backslash");
  }
  if (web::IsOwnHost(text, own)) Require(text.ends_with(":8850"), "another port");
  if (web::IsOwnOrigin(text, own)) Require(text.starts_with("http://"), "a scheme");
  Require(web::CookieIn(text, "key").size() <= text.size(), "a longer cookie");
  Require(web::BearerKeyIn(text).size() <= text.size(), "a longer key");
  if (const auto users = access::ParseUsers(text)) {
    const std::string written = access::TextOf(*users);
    const auto again = access::ParseUsers(written);
    Require(again && access::TextOf(*again) == written, "other users");
  }
  return 0;
}
