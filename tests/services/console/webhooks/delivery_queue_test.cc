#include "services/console/webhooks/delivery_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

constexpr auto kWorks = DeliveryOutcome::kDelivered;
constexpr auto kFails = DeliveryOutcome::kFailed;

class Deliveries : public ::testing::Test {
 protected:
  void Add(const std::string& id, const std::string& event = "state") {
    queue_.Add({id, event, std::make_shared<const std::string>("{}")}, now_);
  }
  /// Makes the attempt that is due; the id of what was sent.
  std::string Try(DeliveryOutcome outcome) {
    const auto next = queue_.NextAttempt();
    EXPECT_TRUE(next);
    if (!next) return "nothing";
    now_ = std::max(now_, *next);
    std::string id = queue_.Begin().id;
    EXPECT_FALSE(queue_.NextAttempt()) << "one attempt at a time";
    queue_.End(outcome, now_);
    return id;
  }
  std::vector<std::string> DeliverAll() {
    std::vector<std::string> ids;
    while (queue_.NextAttempt()) ids.push_back(Try(kWorks));
    return ids;
  }
  DeliveryQueue queue_;
  DeliveryQueue::Time now_{1h};
};

TEST_F(Deliveries, AreMadeInOrderAndAtOnce) {
  EXPECT_FALSE(queue_.NextAttempt());
  Add("a");
  Add("b");
  EXPECT_LE(*queue_.NextAttempt(), now_);
  EXPECT_THAT(DeliverAll(), ElementsAre("a", "b"));
  EXPECT_EQ(queue_.counts().delivered, 2u);
  EXPECT_EQ(queue_.counts().failed_attempts, 0u);
  EXPECT_EQ(queue_.waiting_count(), 0u);
}

TEST_F(Deliveries, AreRetriedAfterDoublingDelaysBeforeWhatFollows) {
  Add("a");
  Add("b");
  std::vector<std::int64_t> delays_s;
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(Try(kFails), "a");
    delays_s.push_back(
        std::chrono::duration_cast<std::chrono::seconds>(*queue_.NextAttempt() - now_)
            .count());
  }
  EXPECT_THAT(delays_s, ElementsAre(1, 2, 4, 8, 16, 32, 64, 128, 256, 300, 300, 300));
  EXPECT_EQ(queue_.failed_in_a_row(), 12u);
  EXPECT_THAT(DeliverAll(), ElementsAre("a", "b"));
  EXPECT_EQ(queue_.failed_in_a_row(), 0u);
  EXPECT_EQ(queue_.counts().failed_attempts, 12u);
  Add("c");
  EXPECT_EQ(Try(kFails), "c");
  EXPECT_EQ(*queue_.NextAttempt() - now_, 1s) << "the delay begins again";
}

TEST_F(Deliveries, NewEventsDoNotHastenAReceiverThatIsDown) {
  Add("a");
  for (int i = 0; i < 4; ++i) Try(kFails);
  Add("b");
  EXPECT_EQ(*queue_.NextAttempt() - now_, 8s);
}

TEST_F(Deliveries, AreGivenUpAfterADay) {
  const auto begin = now_;
  Add("a");
  now_ += 1h;
  Add("b");
  while (queue_.counts().dropped == 0) EXPECT_EQ(Try(kFails), "a");
  EXPECT_GE(now_ - begin, 24h);
  EXPECT_LT(now_ - begin, 24h + 300s);
  EXPECT_THAT(DeliverAll(), ElementsAre("b"));
}

TEST_F(Deliveries, OfAFullQueueTheOldestProgressIsDroppedElseTheOldest) {
  Add("first");
  Add("p1", "progress");
  Add("second");
  Add("p2", "progress");
  for (std::size_t i = queue_.waiting_count(); i < DeliveryQueue::kMaxWaiting; ++i)
    Add("many");
  queue_.Begin();  // "first" is on its way
  Add("new");
  EXPECT_EQ(queue_.counts().dropped, 1u);
  Add("new");
  Add("new");
  EXPECT_EQ(queue_.counts().dropped, 3u);
  EXPECT_EQ(queue_.waiting_count(), DeliveryQueue::kMaxWaiting);
  queue_.End(kWorks, now_);
  const auto ids = DeliverAll();
  EXPECT_EQ(ids.size(), DeliveryQueue::kMaxWaiting - 1);
  EXPECT_EQ(ids.front(), "many") << "both of progress went first, then \"second\"";
  EXPECT_EQ(ids.back(), "new");
}

TEST_F(Deliveries, EndWithAReceiverThatIsGone) {
  Add("a");
  Add("b");
  EXPECT_EQ(Try(DeliveryOutcome::kGone), "a");
  EXPECT_TRUE(queue_.has_ended());
  Add("c");
  EXPECT_FALSE(queue_.NextAttempt());
  EXPECT_EQ(queue_.waiting_count(), 0u);
  EXPECT_EQ(queue_.counts().dropped, 3u);
  EXPECT_EQ(queue_.counts().delivered, 0u);
}

}  // namespace
}  // namespace intaglio::console
