#pragma once

// The web console as a whole: a web server in one thread, the shop in another.

#include <filesystem>
#include <functional>
#include <string>

#include "services/platform/bus/bus.h"

namespace intaglio::console {

struct ConsoleOptions {
  bus::BusOptions bus;
  std::string address = "127.0.0.1";  ///< another than of loopback needs all that follows
  std::string certificate_file, key_file;  ///< PEM; empty: not encrypted
  int port = 0;                            ///< 0: that of the address file, or a free one
  std::filesystem::path address_file;      ///< empty: none
  std::filesystem::path users_file;        ///< of who may log in; empty: nobody
  std::filesystem::path audit_file;        ///< who pressed what; empty: none
  std::filesystem::path materials;         ///< material base; empty: the user's
  std::filesystem::path database;          ///< of the job service; empty: no history
  std::filesystem::path uploads;   ///< folder of jobs' files; empty: none are taken
  std::filesystem::path webhooks;  ///< who gets events (receivers.h); empty: nobody
};

/// Serves until `stopping`; `opened` gets the address once pages can be opened. kIo,
/// kInvalidValue, kUnreadable: it cannot serve there.
Status Serve(const ConsoleOptions& options, const std::function<bool()>& stopping,
             const std::function<void(const std::string& address)>& opened);

struct PingAnswer {
  bool is_accepted = false;
  std::string sentence;  ///< what the receiver answered, for people
};

/// Sends the event `ping` to the receiver of this name in options.webhooks; needs no bus.
/// The errors of ReadReceivers, and kNotFound of another name.
Result<PingAnswer> PingReceiver(const ConsoleOptions& options, const std::string& name);

}  // namespace intaglio::console
