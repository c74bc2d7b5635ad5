#include "services/console/webhooks/receivers.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/platform/access/secret_file.h"
#include "services/platform/text_format/text_format.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxDepth = 4;
constexpr std::size_t kMaxFileBytes = 1 << 18;
constexpr std::size_t kMaxNameBytes = 40;
constexpr std::size_t kMaxUrlBytes = 2000;
constexpr std::size_t kMinSecretBytes = 16;
constexpr std::size_t kMaxSecretBytes = 1024;
constexpr std::uint64_t kMaxCertificateBytes = 4 << 20;
constexpr char kNewSecret[] = "(umask 077; openssl rand -hex 32 > FILE)";
/// As ShopDesk::TakeEvents makes them.
constexpr const char* kKinds[] = {"submitted", "state",    "message",
                                  "warnings",  "progress", "ended"};

/// A URL may have a secret in its path, so only its beginning is printed.
std::string Shown(const std::string& url) {
  const auto scheme = url.find("://");
  const auto begin = scheme == std::string::npos ? 0 : scheme + 3;
  std::string host =
      url.substr(begin, std::min(url.find_first_of("/?#\\", begin), begin + 80) - begin);
  if (const auto at = host.rfind('@'); at != std::string::npos) host.erase(0, at + 1);
  return url.substr(0, begin > 20 ? 0 : begin) + host;
}

class Url {
 public:
  explicit Url(const std::string& text)
      : url_(curl_url(), curl_url_cleanup),
        code_(curl_url_set(url_.get(), CURLUPART_URL, text.c_str(), 0)) {}
  /// nullptr: it is a URL.
  const char* Fault() const {
    return code_ == CURLUE_OK ? nullptr : curl_url_strerror(code_);
  }
  /// "": it has no such part.
  std::string Part(CURLUPart part, unsigned flags = 0) const {
    char* text = nullptr;
    if (curl_url_get(url_.get(), part, &text, flags) != CURLUE_OK) return {};
    const std::unique_ptr<char, void (*)(void*)> kept(text, curl_free);
    return text;
  }
  std::string Place() const {
    return fmt::format("{}://{}:{}", Part(CURLUPART_SCHEME), Part(CURLUPART_HOST),
                       Part(CURLUPART_PORT, CURLU_DEFAULT_PORT));
  }

 private:
  std::unique_ptr<CURLU, void (*)(CURLU*)> url_;
  CURLUcode code_;
};

/// A name that begins with 127 is not of this computer, an address of 127/8 is.
bool IsLoopback(const std::string& host) {
  if (host == "localhost" || host == "[::1]") return true;
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1 &&
         ntohl(address.s_addr) >> 24 == 127;
}

/// Why not; empty: it may be used.
std::string FaultOfUrl(const WebhookReceiver& receiver) {
  const std::string& text = receiver.url();
  if (text.empty()) return "is missing; give https://host[:port]/path";
  if (text.size() > kMaxUrlBytes)
    return fmt::format("{:?} has {}; give at most {}", Shown(text),
                       Counted(text.size(), "byte"), kMaxUrlBytes);
  const Url url(text);
  if (url.Fault() != nullptr)
    return fmt::format("{:?} is no URL ({}); give https://host[:port]/path", Shown(text),
                       url.Fault());
  const std::string scheme = url.Part(CURLUPART_SCHEME);
  if (scheme != "https" && scheme != "http")
    return fmt::format("{:?} is of {}; give https://host[:port]/path", Shown(text),
                       scheme);
  if (!url.Part(CURLUPART_USER).empty() || !url.Part(CURLUPART_PASSWORD).empty())
    return fmt::format(
        "{:?} has a user or a password; leave them out: the signature "
        "proves who sends",
        Shown(text));
  if (scheme == "http" && !receiver.allow_plain_http() &&
      !IsLoopback(url.Part(CURLUPART_HOST)))
    return fmt::format(
        "{:?} is not encrypted and not of this computer; give https://, "
        "or set allow_plain_http when everybody on the way may read the "
        "events",
        Shown(text));
  return {};
}

std::string FaultOfName(const std::string& name) {
  const bool is_plain = std::ranges::all_of(name, [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-');
  });
  if (is_plain && !name.empty() && name.size() <= kMaxNameBytes) return {};
  return fmt::format("{:?} is no name; give 1 to {} letters, digits, '.', '_' and '-'",
                     name.substr(0, kMaxNameBytes), kMaxNameBytes);
}

/// A line for each fault of a receiver.
std::string FaultsOf(const WebhookReceiver& receiver, const std::string& path) {
  std::string faults;
  const auto add = [&](const char* field, const std::string& fault) {
    if (!fault.empty()) faults += fmt::format("{}.{}: {}\n", path, field, fault);
  };
  add("name", FaultOfName(receiver.name()));
  add("url", FaultOfUrl(receiver));
  if (receiver.secret_file().empty())
    add("secret_file", fmt::format("is missing; make one: {}", kNewSecret));
  for (const std::string& event : receiver.events()) {
    if (std::ranges::find(kKinds, event) == std::end(kKinds))
      add("events", fmt::format("{:?} is no kind of event; give some of {}",
                                event.substr(0, kMaxNameBytes), fmt::join(kKinds, ", ")));
  }
  return faults;
}

Result<std::string> ReadSecret(const fs::path& file) {
  std::string secret = INTAGLIO_TRY(access::ReadSecretFile(file, kMaxFileBytes));
  if (secret.ends_with('\n')) secret.pop_back();
  if (secret.ends_with('\r')) secret.pop_back();
  if (secret.size() >= kMinSecretBytes && secret.size() <= kMaxSecretBytes) return secret;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} has a secret of {}; give {} to {}: {}", file.string(),
                          Counted(secret.size(), "byte"), kMinSecretBytes,
                          kMaxSecretBytes, kNewSecret),
              file.string());
}

Status CheckCertificates(const fs::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCertificateBytes));
  if (text.find("-----BEGIN CERTIFICATE-----") != std::string::npos) return {};
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{} has no certificate; give a PEM file that begins with "
                          "-----BEGIN CERTIFICATE-----",
                          file.string()),
              file.string());
}

tl::unexpected<Error> About(Error error, const fs::path& file, int index,
                            const char* field) {
  error.message =
      fmt::format("{}: receivers[{}].{}: {}", file.string(), index, field, error.message);
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

Result<WebhookReceivers> ParseReceivers(std::string_view text, const std::string& name) {
  INTAGLIO_TRY(CheckTextSize(text, name, kMaxFileBytes,
                             "receivers of webhooks (proto/webhook.proto)"));
  WebhookReceivers receivers;
  INTAGLIO_TRY(ParseTextFormat(text, name, kMaxDepth, receivers));
  std::string faults;
  if (receivers.receivers().empty() ||
      receivers.receivers_size() > static_cast<int>(kMaxReceivers))
    faults += fmt::format("receivers: there are {}; give 1 to {}\n",
                          receivers.receivers_size(), kMaxReceivers);
  std::set<std::string> names;
  for (int i = 0; i < receivers.receivers_size(); ++i) {
    const WebhookReceiver& receiver = receivers.receivers(i);
    faults += FaultsOf(receiver, fmt::format("receivers[{}]", i));
    if (!names.insert(receiver.name()).second)
      faults += fmt::format(
          "receivers[{}].name: {:?} is that of another receiver; give each its own\n", i,
          receiver.name().substr(0, kMaxNameBytes));
  }
  if (faults.empty()) return receivers;
  std::string message;
  for (std::size_t begin = 0; begin < faults.size();) {
    const auto end = faults.find('\n', begin);
    message += fmt::format("{}{}: {}", begin == 0 ? "" : "\n", name,
                           faults.substr(begin, end - begin));
    begin = end + 1;
  }
  return Fail(ErrorCode::kInvalidValue, message, name);
}

Result<std::vector<Receiver>> ReadReceivers(const fs::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxFileBytes));
  const auto parsed = INTAGLIO_TRY(ParseReceivers(text, file.string()));
  std::vector<Receiver> receivers;
  for (int i = 0; i < parsed.receivers_size(); ++i) {
    const WebhookReceiver& given = parsed.receivers(i);
    auto secret = ReadSecret(file.parent_path() / given.secret_file());
    if (!secret) return About(std::move(secret).error(), file, i, "secret_file");
    Receiver receiver;
    receiver.name = given.name();
    receiver.url = given.url();
    receiver.place = Url(given.url()).Place();
    receiver.secret = std::move(*secret);
    receiver.events.insert(given.events().begin(), given.events().end());
    if (!given.ca_file().empty()) {
      const fs::path certificates = file.parent_path() / given.ca_file();
      if (auto checked = CheckCertificates(certificates); !checked)
        return About(std::move(checked).error(), file, i, "ca_file");
      receiver.ca_file = certificates.string();
    }
    receivers.push_back(std::move(receiver));
  }
  return receivers;
}

}  // namespace intaglio::console
