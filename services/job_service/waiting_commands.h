#pragma once

// Commands that were read and are not decided yet, by the process that wrote them, so
// that one that floods the topic delays itself: each turn takes one of every process that
// stops something, and then the same number of every process. Used from one thread.

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "services/job_service/records/job_views.h"

namespace intaglio::job_service {

/// Obeying it lets less fire: it takes precedence over commands sent at the same time,
/// and is obeyed also when its client has gone.
bool Stops(const CommandView& command);

class WaitingCommands {
 public:
  /// A client waits for each answer; a console has one for each of its browsers.
  static constexpr std::size_t kMaxOfProcess = 1024;

  struct Entry {
    std::string process;
    CommandView command;
  };
  /// The command that is dropped because too many of this process wait: this one, or for
  /// one that stops the last that does not; nullopt: none. `process`: as
  /// Bus::participant_name().
  std::optional<CommandView> Add(const std::string& process, CommandView command);
  /// Its client was answered, gave up waiting, or is gone: what stops stays.
  void Withdraw(const std::string& sender, std::uint64_t number);
  /// At most `max`, those that stop first, then by sender and number.
  std::vector<Entry> TakeTurn(std::size_t max);

 private:
  struct Before {
    bool operator()(const CommandView& a, const CommandView& b) const;
  };
  using Queue = std::set<CommandView, Before>;
  /// The next one of every process, or of those whose next one stops; false: there is
  /// none.
  bool TakeRound(bool stops_alone, std::size_t max, std::vector<Entry>& turn);

  std::map<std::string, Queue> queues_;  // by process; none is empty
  std::string last_;                     // process that was served last
};

}  // namespace intaglio::job_service
