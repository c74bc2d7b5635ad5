#include "services/console/webhooks/delivery_queue.h"

#include <algorithm>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::console {

void DeliveryQueue::Add(Delivery delivery, Time now) {
  if (has_ended_) {
    ++counts_.dropped;
    return;
  }
  if (waiting_.size() >= kMaxWaiting) DropOne();
  waiting_.push_back({std::move(delivery), now});
}

void DeliveryQueue::DropOne() {
  const auto first = waiting_.begin() + (is_sending_ ? 1 : 0);
  const auto progress = std::find_if(first, waiting_.end(), [](const Waiting& one) {
    return one.delivery.event == "progress";
  });
  waiting_.erase(progress == waiting_.end() ? first : progress);
  ++counts_.dropped;
}

std::optional<DeliveryQueue::Time> DeliveryQueue::NextAttempt() const {
  if (waiting_.empty() || is_sending_ || has_ended_) return std::nullopt;
  return next_;
}

const Delivery& DeliveryQueue::Begin() {
  Require(NextAttempt().has_value(), "no event waits");
  is_sending_ = true;
  return waiting_.front().delivery;
}

void DeliveryQueue::End(DeliveryOutcome outcome, Time now) {
  Require(is_sending_, "no attempt was begun");
  is_sending_ = false;
  if (outcome == DeliveryOutcome::kDelivered) {
    ++counts_.delivered;
    waiting_.pop_front();
    failed_in_a_row_ = 0;
    delay_ = std::chrono::seconds(0);
    next_ = now;
    return;
  }
  ++counts_.failed_attempts;
  ++failed_in_a_row_;
  has_ended_ = outcome == DeliveryOutcome::kGone;
  while (!waiting_.empty() && (has_ended_ || now - waiting_.front().since >= kMaxAge)) {
    waiting_.pop_front();
    ++counts_.dropped;
  }
  delay_ = delay_.count() == 0 ? kFirstDelay : std::min(2 * delay_, kMaxDelay);
  next_ = now + delay_;
}

}  // namespace intaglio::console
