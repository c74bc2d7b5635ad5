#pragma once

// One attempt to deliver an event by HTTP, by libcurl: certificates are checked,
// redirects are not followed, and neither proxies nor files of the environment count.

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "services/console/webhooks/delivery_queue.h"
#include "services/console/webhooks/receivers.h"

namespace intaglio::console {

/// What came of an attempt.
struct WebhookAnswer {
  long status = 0;     ///< of HTTP; 0: no whole answer
  std::string reason;  ///< why there is no whole answer
  std::string body;    ///< its first kMaxKeptBytes

  static constexpr std::size_t kMaxKeptBytes = 500;
  DeliveryOutcome outcome() const;
  /// For people, e.g. "answered 500".
  std::string Sentence() const;
};

/// Makes the attempts of one receiver, over the same connection where it stays open. Used
/// from one thread.
class Transfer {
 public:
  static constexpr std::chrono::seconds kMaxTime{10};
  /// An answer that is longer is cut off: its status counts.
  static constexpr std::size_t kMaxAnswerBytes = 1 << 16;

  explicit Transfer(const Receiver& receiver);
  ~Transfer();
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  /// Before an attempt, which the owner of handle() makes.
  void Prepare(const std::vector<std::string>& headers,
               std::shared_ptr<const std::string> body);
  /// A CURL*.
  void* handle() const;
  /// After the attempt; `code` is the CURLcode with which it ended.
  WebhookAnswer Finish(int code);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::console
