#pragma once

// Machines that are moved and taught by hand from pages. A page sends a message for each
// sample and echoes the number of the machine's state that it saw last; the console
// passes each on once (services/client/teach/jog_relay.h), and sends the machine's states
// to the pages that have sent a message within the last second.

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "proto/console.pb.h"
#include "services/client/teach/jog_relay.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

class JogDesk {
 public:
  using Clock = std::chrono::steady_clock;
  explicit JogDesk(bus::Bus& bus) : relay_(bus) {}

  /// From the server's thread. True: the first message of a press. Errors as of
  /// JogRelay::Pass, and kInvalidValue for an unknown kind.
  Result<bool> Pass(web::PeerId page, const JogRequest& request,
                    const std::string& person, Clock::time_point now);
  /// A page has sent something within the last second.
  bool IsAtWork(Clock::time_point now) const;
  /// A machine by its newest state, from any thread. kNotFound: none came within 2 s.
  Result<client::MachineView> Machine(const std::string& cell,
                                      Clock::time_point now) const;
  /// Those of which a state came within 2 s, by cell, from any thread.
  std::vector<client::MachineView> Machines(Clock::time_point now) const;

  // From the thread that turns the shop.

  /// Who gets what.
  std::vector<std::pair<web::PeerId, JogView>> TakeNew(Clock::time_point now);

 private:
  struct Page {
    std::string cell;
    std::uint32_t press = 0;
    std::uint64_t number = 0;  // of its order; the state at which the press began
    Clock::time_point sent;
  };
  struct Known {
    client::MachineView view;
    Clock::time_point taken;
  };
  void ForgetPages(Clock::time_point now);

  static constexpr std::chrono::seconds kQuietTime{1};
  /// Four periods of a machine that nobody moves.
  static constexpr std::chrono::seconds kKnownTime{2};

  client::JogRelay relay_;
  mutable std::mutex mutex_;  // of what follows
  std::map<web::PeerId, Page> pages_;
  std::map<std::string, Known> machines_;  // by cell
};

}  // namespace intaglio::console
