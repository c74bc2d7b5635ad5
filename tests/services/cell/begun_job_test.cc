#include "services/cell/begun_job.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::cell {
namespace {

TEST(BegunJob, TheZerosThatAJobWasBegunWithComeBackBitForBit) {
  const auto folder = test::FreshFolder();
  const auto none = ReadBegunJob(folder);
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_FALSE(none->has_value());
  FrozenJob job;
  TaughtZero& zero = *job.mutable_machine()->mutable_taught()->add_zeros();
  zero.set_channel(2);
  zero.mutable_block_origin_mm()->set_x(1.0 / 3);
  ASSERT_TRUE(WriteBegunJob(folder, job));
  const auto begun = ReadBegunJob(folder);
  ASSERT_TRUE(begun) << begun.error().message;
  ASSERT_TRUE(begun->has_value());
  EXPECT_EQ((*begun)->machine().taught().zeros(0).channel(), 2u);
  EXPECT_EQ((*begun)->machine().taught().zeros(0).block_origin_mm().x(), 1.0 / 3);
}

TEST(BegunJob, ADamagedFileIsAnErrorAndNotTakenForNone) {
  const auto folder = test::FreshFolder();
  std::ofstream(folder / kJobFile) << "{ torn";
  const auto damaged = ReadBegunJob(folder);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, ErrorCode::kUnreadable);
  EXPECT_NE(damaged.error().message.find(kJobFile), std::string::npos);
}

}  // namespace
}  // namespace intaglio::cell
