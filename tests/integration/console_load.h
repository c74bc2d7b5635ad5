#pragma once

// Clients of a console that are slow, many or broken, all at once, for tests. Each kind
// is renewed all the time, because the console ends what is silent for 10 s.

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/services/platform/web/web_client.h"

namespace intaglio::testing {

struct LoadOptions {
  int half_open_count = 500;   ///< connections with a part of a request
  int slow_reader_count = 50;  ///< of the state, the events, or the script of the view
  double requests_per_second = 1000;  ///< of all clients together, when they are answered
  int client_count = 40;              ///< one request of each is under way
};

class ConsoleLoad {
 public:
  /// Loads the console of this port until it goes.
  ConsoleLoad(std::uint16_t port, std::string key, LoadOptions options);
  ~ConsoleLoad() = default;
  ConsoleLoad(const ConsoleLoad&) = delete;
  ConsoleLoad& operator=(const ConsoleLoad&) = delete;

  int answered_count() const { return answered_; }
  /// Requests of clients that were answered otherwise than by 200, or not at all.
  int refused_count() const { return refused_; }
  /// Connections that the console ended because of a malformed frame.
  int broken_count() const { return broken_; }
  /// Those that it did not end within 20 s.
  int survived_count() const { return survived_; }

 private:
  void KeepHalfOpen(const std::stop_token& end);
  void KeepSlowReaders(const std::stop_token& end);
  void SendRequests(const std::stop_token& end, int client);
  void SendMalformedFrames(const std::stop_token& end);
  test::WebConnection SlowReader(int kind) const;

  std::uint16_t port_;
  std::string key_;
  LoadOptions options_;
  std::atomic<int> answered_ = 0, refused_ = 0, broken_ = 0, survived_ = 0;
  std::vector<std::jthread> threads_;  // the last: they use all others
};

/// The value below which this share of the values lies; 0 of none.
double Share(std::vector<double> values, double ratio);

}  // namespace intaglio::testing
