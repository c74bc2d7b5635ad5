#include "services/job_service/waiting_commands.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace intaglio::job_service {

bool Stops(const CommandView& command) {
  return command.kind == intaglio_COMMAND_PAUSE ||
         command.kind == intaglio_COMMAND_CANCEL;
}

bool WaitingCommands::Before::operator()(const CommandView& a,
                                         const CommandView& b) const {
  if (Stops(a) != Stops(b)) return Stops(a);
  return std::tie(a.sender, a.number) < std::tie(b.sender, b.number);
}

std::optional<CommandView> WaitingCommands::Add(const std::string& process,
                                                CommandView command) {
  Queue& queue = queues_[process];
  if (queue.size() < kMaxOfProcess) {
    queue.insert(std::move(command));
    return std::nullopt;
  }
  if (queue.contains(command)) return std::nullopt;  // delivered again
  const auto last = std::prev(queue.end());
  if (!Stops(command) || Stops(*last)) return command;
  CommandView dropped = std::move(queue.extract(last).value());
  queue.insert(std::move(command));
  return dropped;
}

void WaitingCommands::Withdraw(const std::string& sender, std::uint64_t number) {
  for (auto& [process, queue] : queues_) {
    CommandView withdrawn;  // an arm, which does not stop
    withdrawn.sender = sender;
    withdrawn.number = number;
    queue.erase(withdrawn);
  }
  std::erase_if(queues_, [](const auto& entry) { return entry.second.empty(); });
}

bool WaitingCommands::TakeRound(bool stops_alone, std::size_t max,
                                std::vector<Entry>& turn) {
  bool any = false;
  auto place = queues_.upper_bound(last_);
  for (std::size_t i = 0; i < queues_.size() && turn.size() < max; ++i, ++place) {
    if (place == queues_.end()) place = queues_.begin();
    Queue& queue = place->second;
    if (queue.empty() || (stops_alone && !Stops(*queue.begin()))) continue;
    turn.push_back({place->first, std::move(queue.extract(queue.begin()).value())});
    last_ = place->first;
    any = true;
  }
  return any;
}

std::vector<WaitingCommands::Entry> WaitingCommands::TakeTurn(std::size_t max) {
  std::vector<Entry> turn;
  TakeRound(true, max, turn);
  while (TakeRound(false, max, turn)) {
  }
  std::erase_if(queues_, [](const auto& entry) { return entry.second.empty(); });
  std::ranges::sort(turn, Before(), &Entry::command);
  return turn;
}

}  // namespace intaglio::job_service
