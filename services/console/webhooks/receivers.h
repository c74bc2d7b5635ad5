#pragma once

// Who gets the events of a shop: the text format of proto/webhook.proto, checked, with
// the secrets that it names.

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/webhook.pb.h"

namespace intaglio::console {

inline constexpr std::size_t kMaxReceivers = 16;

struct Receiver {
  std::string name;
  std::string url;
  std::string place;             ///< "https://host:port": what may be printed of the URL
  std::string secret;            ///< its bytes; never printed
  std::set<std::string> events;  ///< kinds, as JobEvent has them; empty: all
  std::string ca_file;           ///< empty: the system's certificates

  bool Wants(const std::string& event) const {
    return events.empty() || events.contains(event);
  }
};

/// kTooLarge, kUnreadable with "name:line:column: what", kInvalidValue with all that is
/// wrong, a line each: the field, its value and the remedy. Opens no file.
Result<WebhookReceivers> ParseReceivers(std::string_view text, const std::string& name);

/// kNotFound, kIo and kRefused (others can read a secret) besides.
Result<std::vector<Receiver>> ReadReceivers(const std::filesystem::path& file);

}  // namespace intaglio::console
