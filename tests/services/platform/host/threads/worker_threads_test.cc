#include "services/platform/host/threads/worker_threads.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

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
  std::atomic<int> at_work = 0, largest = 0;
  OnThreads(2)(200, [&](std::size_t) {
    const int now = ++at_work;
    int seen = largest;
    while (now > seen && !largest.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::yield();
    --at_work;
  });
  EXPECT_LE(largest, 2);
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

// A computation of a service in real time must not keep its heartbeat from a core.
TEST(GiveWay, InRealTimeIsOnePriorityBehindTheProcess) {
  const sched_param ten{10}, none{0};
  if (sched_setscheduler(getpid(), SCHED_RR, &ten) != 0) {
    GTEST_SKIP()
        << "real-time scheduling is not granted: run as root or with ulimit -r 10";
  }
  int once = 0, again = 0;
  std::thread([&] {
    sched_param own{};
    GiveWay();
    (void)sched_getparam(0, &own);
    once = own.sched_priority;
    GiveWay();
    (void)sched_getparam(0, &own);
    again = own.sched_priority;
  }).join();
  (void)sched_setscheduler(getpid(), SCHED_OTHER, &none);
  EXPECT_EQ(once, 9);
  EXPECT_EQ(again, 9) << "helpers of a computation are not behind it";
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
