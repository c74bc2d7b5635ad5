#pragma once

// Events of the shop to other programs by HTTP, in a thread of their own, in which every
// receiver has one transfer at a time. What waits is kept in memory only.

#include <memory>
#include <string>
#include <vector>

#include "services/console/webhooks/receivers.h"
#include "services/console/webhooks/transfer.h"

namespace intaglio::console {

class Webhooks {
 public:
  /// Without receivers there is no thread.
  explicit Webhooks(std::vector<Receiver> receivers);
  /// Waits for no receiver: what has not been delivered is lost.
  ~Webhooks();
  Webhooks(const Webhooks&) = delete;
  Webhooks& operator=(const Webhooks&) = delete;

  // From any thread; no receiver delays the caller.

  /// For every receiver that wants this kind. `line`: a JobEvent in one line of JSON.
  void Publish(const std::string& line);
  /// In the text format of Prometheus, as ShopMetrics; empty without receivers.
  std::string Metrics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sends the event `ping` and waits for the answer, kMaxTime at most.
WebhookAnswer Ping(const Receiver& receiver);

}  // namespace intaglio::console
