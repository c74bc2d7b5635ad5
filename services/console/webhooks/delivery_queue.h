#pragma once

// The events that wait for one receiver, oldest first, and when the next attempt is made.
//
// clang-format off
//                Add                       Begin                  End(kDelivered)
//   empty -----------------> waiting ----------------> attempt ------------------> next
//                               ^                         |   End(kGone): ended, all dropped
//                               +----- End(kFailed) ------+
//                          retry after 1 s, 2 s, 4 s ... 5 min
// clang-format on
//
// 1. One attempt at a time, and the oldest event first: a receiver gets events in order.
// 2. The delay doubles with each failed attempt in a row, whatever the event, so that a
//    receiver that is down gets an attempt every 5 minutes and not one for each event.
// 3. After a failed attempt events of 24 h or more are dropped.
// 4. At most kMaxWaiting events wait. Then the oldest `progress` is dropped, whose
//    successors have its information; without one the oldest event. Never the one that is
//    being sent.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace intaglio::console {

struct Delivery {
  std::string id;     ///< the same in every attempt
  std::string event;  ///< its kind, as JobEvent has it
  std::shared_ptr<const std::string> body;
};

enum class DeliveryOutcome {
  kDelivered,
  kFailed,
  kGone,  ///< the receiver wants nothing any more
};

struct DeliveryCounts {
  std::uint64_t delivered = 0;
  std::uint64_t failed_attempts = 0;
  std::uint64_t dropped = 0;
};

/// Used from one thread at a time. The caller has the clock.
class DeliveryQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t kMaxWaiting = 1000;
  static constexpr std::chrono::seconds kFirstDelay{1};
  static constexpr std::chrono::seconds kMaxDelay{300};
  static constexpr std::chrono::hours kMaxAge{24};

  void Add(Delivery delivery, Time now);
  /// When the next attempt is due, maybe in the past; nullopt: nothing waits, an attempt
  /// is being made, or the receiver has ended.
  std::optional<Time> NextAttempt() const;
  /// The oldest event. Only when NextAttempt() has a time.
  const Delivery& Begin();
  /// The attempt that was begun has ended so.
  void End(DeliveryOutcome outcome, Time now);

  const DeliveryCounts& counts() const { return counts_; }
  /// Failed attempts since the last that succeeded.
  std::uint64_t failed_in_a_row() const { return failed_in_a_row_; }
  std::size_t waiting_count() const { return waiting_.size(); }
  bool has_ended() const { return has_ended_; }

 private:
  struct Waiting {
    Delivery delivery;
    Time since;
  };
  void DropOne();

  std::deque<Waiting> waiting_;
  bool is_sending_ = false;  ///< the first of waiting_
  bool has_ended_ = false;
  std::uint64_t failed_in_a_row_ = 0;
  std::chrono::seconds delay_{0};
  Time next_{};
  DeliveryCounts counts_;
};

}  // namespace intaglio::console
