#include "services/host/worker_threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;

TEST(AllCores, DoesEachPieceOnce) {
  for (const std::size_t count : {0, 1, 2, 1000}) {
    std::vector<std::atomic<int>> done(count);
    AllCores()(count, [&](std::size_t i) { ++done.at(i); });
    for (const auto& times : done) EXPECT_EQ(times, 1);
  }
}

TEST(OnThreads, TakesNoMoreThanItIsGiven) {
  std::atomic<int> at_work = 0, most = 0;
  OnThreads(2)(200, [&](std::size_t) {
    const int now = ++at_work;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::yield();
    --at_work;
  });
  EXPECT_LE(most, 2);
}

TEST(AllCores, PassesOnWhatWasThrown) {
  constexpr int kCount = 5000;
  std::atomic<int> begun = 0;
  const auto work = [&](std::size_t i) {
    ++begun;
    if (i == 3) throw std::runtime_error("the third");
    std::this_thread::sleep_for(1ms);  // who throws may have to wait for its turn
  };
  EXPECT_THROW(AllCores()(kCount, work), std::runtime_error);
  EXPECT_LT(begun, kCount) << "the rest is not begun";
}

TEST(ShareOfTime, GrowsToOneAndBeyond) {
  const auto share = ShareOfTime(1e-3);
  double last = share();
  while (last < 1) {
    const double next = share();
    ASSERT_GE(next, last);
    last = next;
  }
  EXPECT_LT(ShareOfTime(1e6)(), 0.01);
}

}  // namespace
}  // namespace intaglio::host
