#include "services/discretizer/kept_job.h"

#include <gtest/gtest.h>

namespace intaglio::discretizer {
namespace {

using namespace std::chrono_literals;
using Job = std::shared_ptr<const int>;

class KeptJobTest : public testing::Test {
 protected:
  /// A part of this job, and whether it found it made.
  bool Part(const std::string& job_uid, std::uint32_t attempt, bool withdrawn = false) {
    kept.Begin(job_uid, attempt);
    const bool found = kept.holds_job();
    if (!found) *kept.slot() = std::make_shared<const int>(42);
    kept.DropWhenOld(now += 1h);  // it may take its time
    EXPECT_TRUE(kept.holds_job());
    kept.End(withdrawn, now);
    return found;
  }

  KeptJob<Job> kept;
  KeptJob<Job>::TimePoint now{};
};

TEST_F(KeptJobTest, IsThereForTheNextPartOfTheSameJobAndAttempt) {
  EXPECT_FALSE(Part("a", 1));
  EXPECT_TRUE(Part("a", 1));
  EXPECT_FALSE(Part("a", 2)) << "another attempt";
  EXPECT_FALSE(Part("b", 2)) << "another job";
  EXPECT_FALSE(Part("a", 2)) << "it was dropped for that one";
}

TEST_F(KeptJobTest, IsDroppedWhenItIsOld) {
  Part("a", 1);
  kept.DropWhenOld(now += 9s);
  EXPECT_TRUE(Part("a", 1));
  kept.DropWhenOld(now += 10s);
  EXPECT_FALSE(kept.holds_job());
  EXPECT_FALSE(Part("a", 1));
}

TEST_F(KeptJobTest, IsDroppedWhenTheTaskIsWithdrawn) {
  Part("a", 1, true);
  EXPECT_FALSE(Part("a", 1));
}

TEST_F(KeptJobTest, IsNotThereAfterAFailure) {
  kept.Begin("a", 1);
  kept.End(false, now);
  kept.Begin("a", 1);
  EXPECT_FALSE(kept.holds_job());
}

}  // namespace
}  // namespace intaglio::discretizer
