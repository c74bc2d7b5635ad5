#include "services/platform/host/process/bounded_end.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;

TEST(BoundedEndDeathTest, AProcessThatLoopsForGoodIsEndedWithItsCode) {
  EXPECT_EXIT(
      {
        EndWithin(1s, 7);
        for (;;) sleep(1);
      },
      testing::ExitedWithCode(7), "hangs in the DDS library");
}

TEST(BoundedEndDeathTest, AProcessThatEndsIsNotDisturbed) {
  EXPECT_EXIT(
      {
        EndWithin(5s, 7);
        _exit(3);
      },
      testing::ExitedWithCode(3), "^$");
}

}  // namespace
}  // namespace intaglio::host
