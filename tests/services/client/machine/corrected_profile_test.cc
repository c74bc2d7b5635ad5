#include "services/client/machine/corrected_profile.h"

#include <gmock/gmock.h>

#include "services/job/checks/job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

MachineSpec PlacedEls03() {
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
  machine.mutable_block_origin_mm()->set_x(100);
  machine.mutable_block_origin_mm()->set_y(50);
  return machine;
}

/// A fit of a machine that is as its profile, known to 1e-5, 1 um and 5 us.
calibrate::MachineFit Right() {
  calibrate::MachineFit fit;
  for (auto& axis : fit.axes) {
    axis.scale_ratio = {1, 1e-5};
    axis.backlash_mm = {0, 0.001};
    axis.lag_s = {0, 5e-6};
  }
  fit.squareness_rad = {0, 1e-5};
  return fit;
}

TEST(CorrectedProfile, OfARightMachineIsItsOwn) {
  calibrate::MachineFit fit = Right();
  fit.axes[0].scale_ratio.value = 1.000009;  // within its uncertainty
  const auto corrected = Correct(PlacedEls03(), fit);
  EXPECT_THAT(corrected.corrections, IsEmpty());
  EXPECT_THAT(corrected.remarks, IsEmpty());
  EXPECT_EQ(corrected.machine.SerializeAsString(), PlacedEls03().SerializeAsString());
}

TEST(CorrectedProfile, HasWhatWasFound) {
  calibrate::MachineFit fit = Right();
  fit.axes[0].scale_ratio.value = 1.0004;
  fit.squareness_rad.value = -0.0005;
  fit.axes[0].lag_s.value = fit.axes[1].lag_s.value = 0.0003;
  fit.axes[1].backlash_mm.value = 0.012;
  const auto corrected = Correct(PlacedEls03(), fit);
  EXPECT_THAT(corrected.corrections,
              ElementsAre("cartesian.x.scale_ratio: 1 -> 1.0004",
                          "cartesian.squareness_xy_rad: 0 -> -0.0005",
                          "stage_lag_s: 0.0002 -> 0.0005"));
  EXPECT_THAT(corrected.remarks,
              ElementsAre(HasSubstr("y has a backlash of 12.0 um, which no profile")));
  EXPECT_TRUE(CheckMachine(corrected.machine).empty());
  EXPECT_FALSE(corrected.machine.cartesian().y().has_scale_ratio());
}

// The corner of the block was found by driving to it: the axes there are what they were.
TEST(CorrectedProfile, TheBlockStaysWhereItIs) {
  calibrate::MachineFit fit = Right();
  fit.axes[0].scale_ratio.value = 1.002;
  fit.squareness_rad.value = 0.001;
  MachineSpec machine = PlacedEls03();
  machine.mutable_cartesian()->mutable_x()->set_moves(AXIS_MOVES_TABLE);
  const auto corrected = Correct(machine, fit);
  const auto axes_at = [](const MachineSpec& m) {
    const Vector3& at = m.block_origin_mm();
    return KinematicsOf(m)->ToAxes({at.x(), at.y(), at.z()}, {}).value();
  };
  EXPECT_LT((axes_at(machine) - axes_at(corrected.machine)).norm(), 2e-6);
  // By hand: x 100 mm of a scale 1.002 and 50 mm of y towards it by 0.001.
  EXPECT_NEAR(corrected.machine.block_origin_mm().x(), 100.2 + 0.05, 1e-4);
}

TEST(CorrectedProfile, WhatNoProfileCorrectsIsARemark) {
  calibrate::MachineFit fit = Right();
  fit.axes[0].lag_s.value = 0.0001;
  fit.axes[1].lag_s.value = 0.0002;
  fit.axes[0].backlash_mm.value = -0.005;
  const auto corrected = Correct(PlacedEls03(), fit);
  EXPECT_THAT(corrected.remarks,
              ElementsAre(HasSubstr("x comes 5.0 um too far in both directions")));
  EXPECT_THAT(corrected.corrections,
              ElementsAre("axis_drives: x: stage_lag_s: 0.0002 -> 0.0003",
                          "axis_drives: y: stage_lag_s: 0.0002 -> 0.0004"));
  EXPECT_TRUE(CheckMachine(corrected.machine).empty());
  // Measured again with it, only y is late.
  fit.axes[0] = Right().axes[0];
  fit.axes[1].lag_s.value = -0.0001;
  const auto again = Correct(corrected.machine, fit);
  EXPECT_THAT(again.corrections,
              ElementsAre("axis_drives: y: stage_lag_s: 0.0004 -> 0.0003"));
  ASSERT_EQ(again.machine.axis_drives_size(), 2);
  fit = Right();
  fit.axes[0].lag_s.value = fit.axes[1].lag_s.value = 0.2;
  EXPECT_THAT(Correct(PlacedEls03(), fit).remarks,
              ElementsAre(HasSubstr("a lag of 200200 us is outside")));
}

}  // namespace
}  // namespace intaglio::client
