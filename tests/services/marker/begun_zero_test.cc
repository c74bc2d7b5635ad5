#include "services/marker/begun_zero.h"

#include <gmock/gmock.h>

#include <fstream>

#include "services/cell/begun_job.h"
#include "tests/test_folder.h"

namespace intaglio::marker {
namespace {

using testing::HasSubstr;

class BegunZeroTest : public testing::Test {
 protected:
  BegunZeroTest() {
    job_.set_job_uid("1-a");
    job_.set_result_directory(test::FreshFolder().string());
    state_.link_up = true;
    state_.work_offset_mm = Vec3(20, 5, -7);
    EXPECT_TRUE(zero_.Begin(job_, false));
  }
  const std::string& Waits(bool has_grant) {
    zero_.Turn(job_, state_, {.started = false, .has_grant = has_grant});
    return zero_.refusal();
  }
  const std::string& Started(bool has_grant = true) {
    zero_.Turn(job_, state_, {.started = true, .has_grant = has_grant});
    return zero_.refusal();
  }
  std::optional<Vec3> OnDisk() const {
    const auto begun = cell::ReadBegunJob(job_.result_directory());
    if (!begun || !begun->has_value()) return std::nullopt;
    const auto& taught = (*begun)->machine().taught();
    if (taught.zeros_size() != 1) return std::nullopt;
    const Vector3& place = taught.zeros(0).block_origin_mm();
    return Vec3(place.x(), place.y(), place.z());
  }
  /// Another process takes the job up.
  void Restart() {
    zero_ = {};
    ASSERT_TRUE(zero_.Begin(job_, true));
  }
  void Move(double x_mm) { state_.work_offset_mm = Vec3(x_mm, 5, -7); }

  FrozenJob job_;
  drivers::MarkDeviceState state_;
  BegunZero zero_;
};

TEST_F(BegunZeroTest, AJobThatWaitsTakesTheZeroOfItsGrant) {
  EXPECT_EQ(Waits(false), "");
  EXPECT_FALSE(OnDisk());
  Waits(true);
  EXPECT_EQ(OnDisk(), Vec3(20, 5, -7));
  Move(27);
  Waits(false);
  EXPECT_EQ(OnDisk(), Vec3(20, 5, -7));
  EXPECT_EQ(Waits(true), "");
  EXPECT_EQ(OnDisk(), Vec3(27, 5, -7));
}

TEST_F(BegunZeroTest, ABegunJobRefusesAnotherZeroUntilItIsBackOverRestartsToo) {
  Waits(true);
  for (const bool restarted : {false, true}) {
    SCOPED_TRACE(restarted);
    if (restarted) Restart();
    EXPECT_EQ(Started(), "");
    Move(27);
    EXPECT_THAT(Started(),
                testing::AllOf(HasSubstr("27.000, 5.000, -7.000"),
                               HasSubstr("begun with 20.000, 5.000, -7.000"),
                               HasSubstr("move the tool to -7.000, 0.000, 0.000")));
    state_.link_up = false;
    EXPECT_NE(Started(), "") << "what it was before the line was lost";
    state_.link_up = true;
    Move(20.001);
    EXPECT_EQ(Started(), "");
    EXPECT_EQ(OnDisk(), Vec3(20, 5, -7));
  }
}

// The axes count from where they were switched on.
TEST_F(BegunZeroTest, BehindALostPlaceTheZeroOfThePersonCounts) {
  Waits(true);
  for (const bool restarted : {false, true}) {
    SCOPED_TRACE(restarted);
    if (restarted) Restart();
    const auto before = OnDisk();
    ++state_.axes_number;
    state_.place_lost = "set the zero";
    Move(restarted ? 3 : 1);
    EXPECT_EQ(Started(), "");
    state_.place_lost.clear();
    EXPECT_EQ(Started(false), "");
    EXPECT_EQ(OnDisk(), before) << "before a person has armed";
    EXPECT_EQ(Started(), "");
    EXPECT_EQ(OnDisk(), *state_.work_offset_mm);
    Move(9);
    EXPECT_NE(Started(), "") << "it is the zero of the job from now on";
  }
}

TEST_F(BegunZeroTest, ATakeUpInTheSameProcessForgetsNoAxes) {
  state_.axes_number = 1;
  Waits(true);
  ASSERT_TRUE(zero_.Begin(job_, true));
  Move(27);
  EXPECT_NE(Started(), "");
}

TEST_F(BegunZeroTest, AZeroThatNobodyWroteIsRefusedByItsFile) {
  ASSERT_TRUE(cell::WriteBegunJob(job_.result_directory(), job_));
  Restart();
  EXPECT_THAT(Started(), HasSubstr("job.json has no work zero"));
  std::ofstream(std::filesystem::path(job_.result_directory()) / cell::kJobFile) << "{";
  zero_ = {};
  EXPECT_FALSE(zero_.Begin(job_, true));
}

TEST_F(BegunZeroTest, AMachineWithoutSuchAZeroIsNotAsked) {
  state_.work_offset_mm.reset();
  Waits(true);
  EXPECT_EQ(Started(), "");
  EXPECT_FALSE(OnDisk());
}

}  // namespace
}  // namespace intaglio::marker
