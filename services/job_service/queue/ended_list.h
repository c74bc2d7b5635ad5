#pragma once

// Which of what has ended may be forgotten. The newest `kept` stay, for clients that list
// them; and each stays for `time` at least, so that a client that follows it reads its
// last state before its DDS instance is disposed. Used from one thread.

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>

namespace intaglio::job_service {

class EndedList {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  EndedList(std::size_t kept, Nanoseconds time) : kept_(kept), time_(time) {}

  void Add(std::string key, Nanoseconds now) { ended_.emplace_back(now, std::move(key)); }

  /// The oldest that may be forgotten now, each once.
  std::optional<std::string> TakeOldest(Nanoseconds now) {
    if (ended_.size() <= kept_ || now - ended_.front().first < time_) return {};
    std::string key = std::move(ended_.front().second);
    ended_.pop_front();
    return key;
  }

 private:
  std::size_t kept_;
  Nanoseconds time_;
  std::deque<std::pair<Nanoseconds, std::string>> ended_;  // oldest end first
};

}  // namespace intaglio::job_service
