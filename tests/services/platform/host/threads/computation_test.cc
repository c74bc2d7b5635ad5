#include "services/platform/host/threads/computation.h"

#include <gtest/gtest.h>

#include <semaphore>

namespace intaglio::host {
namespace {

TEST(Computation, GivesItsResultAndWakes) {
  std::binary_semaphore woken(0);
  Computation<int> computation(
      [](const ProgressSink& progress) -> Result<int> {
        EXPECT_TRUE(progress(3, 4));
        return 42;
      },
      [&woken] { woken.release(); });
  woken.acquire();
  ASSERT_TRUE(computation.ready());
  EXPECT_EQ(computation.done(), 3u);
  EXPECT_EQ(computation.total(), 4u);
  EXPECT_EQ(computation.Take().value(), 42);
}

TEST(Computation, EndsWhenCancelled) {
  std::binary_semaphore started(0), woken(0);
  Computation<int> computation(
      [&started](const ProgressSink& progress) -> Result<int> {
        started.release();
        while (progress(0, 0)) std::this_thread::yield();
        return Fail(ErrorCode::kCancelled, "cancelled");
      },
      [&woken] { woken.release(); });
  started.acquire();
  EXPECT_FALSE(computation.ready());
  computation.Cancel();
  woken.acquire();
  EXPECT_EQ(computation.Take().error().code, ErrorCode::kCancelled);
}

TEST(Computation, CancelsAndJoinsWhenItIsDropped) {
  bool ended = false;
  {
    Computation<int> computation(
        [&ended](const ProgressSink& progress) -> Result<int> {
          while (progress(0, 0)) std::this_thread::yield();
          ended = true;
          return 0;
        },
        [] {});
  }
  EXPECT_TRUE(ended);
}

TEST(Computation, TurnsExceptionsIntoErrors) {
  Computation<int> logic(
      [](const ProgressSink&) -> Result<int> {
        throw std::logic_error("spacing_mm is -1");
      },
      [] {});
  const auto failed = logic.Take();
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kFault);
  EXPECT_NE(failed.error().message.find("spacing_mm is -1"), std::string::npos);

  Computation<int> memory(
      [](const ProgressSink&) -> Result<int> { throw std::bad_alloc(); }, [] {});
  EXPECT_EQ(memory.Take().error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::host
