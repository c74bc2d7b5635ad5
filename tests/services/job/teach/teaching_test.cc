#include "services/job/teach/teaching.h"

#include <gmock/gmock.h>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kRatio = 0.65;

MachineSpec TableOf(const LinearAxis& axis) {
  MachineSpec machine = GoodMachine();
  *machine.mutable_cartesian()->mutable_x() = axis;
  *machine.mutable_cartesian()->mutable_y() = axis;
  for (AxisLimits* limits : {machine.mutable_x(), machine.mutable_y()}) {
    limits->set_travel_min_mm(-200);
    limits->set_travel_max_mm(200);
  }
  return machine;
}

FrozenJob FrozenOn(const MachineSpec& machine, std::uint32_t channel = 1) {
  FrozenJob frozen;
  *frozen.mutable_machine() = machine;
  JobSpec job = GoodJob();
  job.mutable_laser()->add_channels(channel);
  *frozen.mutable_job() = WithDefaults(std::move(job), machine);
  frozen.mutable_optics()->set_stage_per_glass_ratio(kRatio);
  return frozen;
}

MachineSpec With(MachineSpec machine, const Result<TaughtPositions>& taught) {
  EXPECT_TRUE(taught.has_value()) << (taught ? "" : taught.error().message);
  if (taught) *machine.mutable_taught() = *taught;
  return machine;
}

std::vector<MachineSpec> AllKinds() {
  std::vector<MachineSpec> kinds = {GoodMachine()};
  for (const bool reversed : {false, true}) {
    for (const AxisMoves moves : {AXIS_MOVES_HEAD, AXIS_MOVES_TABLE}) {
      LinearAxis axis;
      axis.set_moves(moves);
      axis.set_reversed(reversed);
      kinds.push_back(TableOf(axis));
    }
  }
  kinds.push_back(
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value());
  return kinds;
}

// The definition of a zero: a point of the glass is reached where the person saw it.
// Moving parts, reversed axes and axes that turn do not change it.
TEST(Teaching, ThePlaceThatWasTaughtIsReachedWithTheAxesAsTheyWere) {
  for (const MachineSpec& machine : AllKinds()) {
    const FrozenJob before = FrozenOn(machine);
    const Vec3 top_corner(0, 0, BlockSizeOf(before.job()).z());
    const Vec3 near = machine::BranchStart(AxisLimitsOf(machine).travel_mm);
    const Vec3 at = AxesFromGlassOf(before).ToAxes(top_corner, near).value() +
                    Vec3(0.013, -0.021, 0.4);
    ZeroChoice choice;
    choice.at_glass_mm = top_corner;
    choice.lens = machine.lenses(0).name();
    const FrozenJob after = FrozenOn(With(machine, WithZero(machine, at, choice)));
    const Vec3 reached = AxesFromGlassOf(after).ToAxes(top_corner, at).value();
    EXPECT_LT((reached - at).norm(), 1e-9) << machine.DebugString();
  }
}

// Init of the source's teach window: back to where the zero was taught, on all kinds of
// axes, for the lens and the channel of that zero.
TEST(Teaching, TheZeroIsWhereItWasTaught) {
  for (const MachineSpec& machine : AllKinds()) {
    const Vec3 near = machine::BranchStart(AxisLimitsOf(machine).travel_mm);
    ZeroChoice choice;
    choice.at_glass_mm = Vec3(0, 0, 40);
    choice.lens = machine.lenses(0).name();
    const Vec3 at = AxesAtZero(machine, near, choice).value() + Vec3(0.01, -0.02, 0.3);
    const MachineSpec taught = With(machine, WithZero(machine, at, choice));
    EXPECT_LT((AxesAtZero(taught, at, choice).value() - at).norm(), 1e-9);
    ZeroChoice other = choice;
    other.lens = machine.lenses(1).name();
    EXPECT_GT((AxesAtZero(taught, at, other).value() - at).norm(), 0.01);
    other.lens = "f99";
    EXPECT_EQ(AxesAtZero(taught, at, other).error().code, ErrorCode::kNotFound);
    other = choice;
    other.channel = machine.laser().channels() + 1;
    EXPECT_EQ(AxesAtZero(taught, at, other).error().code, ErrorCode::kNotFound);
  }
}

// The picture in the glass is not mirrored by what moves: in the frame that is fixed to
// the block, a table that is driven to +x takes the focus to -x. So along growing x of
// the glass its axis has to fall, and the taught zero has no part in it.
TEST(Teaching, AMovingTableIsNotMirrored) {
  LinearAxis table;
  table.set_moves(AXIS_MOVES_TABLE);
  const MachineSpec machine = TableOf(table);
  ZeroChoice choice;
  choice.lens = machine.lenses(0).name();
  const Vec3 at(37, -12, 20);
  const auto axes =
      AxesFromGlassOf(FrozenOn(With(machine, WithZero(machine, at, choice))));
  const double z = axes.ToAxes(Vec3::Zero(), at)->z();
  EXPECT_EQ(axes.ToAxes(Vec3(0, 0, 0), at).value(), Vec3(37, -12, z));
  EXPECT_EQ(axes.ToAxes(Vec3(5, 0, 0), at).value(), Vec3(32, -12, z));
  EXPECT_EQ(axes.ToAxes(Vec3(0, 7, 0), at).value(), Vec3(37, -19, z));
}

TEST(Teaching, AZeroHoldsForItsChannelAndLensOnly) {
  MachineSpec machine = GoodMachine();
  machine.mutable_laser()->set_channels(2);
  ASSERT_GE(machine.lenses_size(), 2);
  ZeroChoice choice;
  choice.channel = 2;
  choice.lens = machine.lenses(0).name();
  const MachineSpec taught = With(machine, WithZeroMoved(machine, Vec3(1, 2, 3), choice));
  const Vec3 own = Vec3Of(machine.block_origin_mm());
  EXPECT_EQ(BlockOriginOf(taught, 2, machine.lenses(0).name()), own + Vec3(1, 2, 3));
  EXPECT_EQ(BlockOriginOf(taught, 1, machine.lenses(0).name()), own);
  EXPECT_EQ(BlockOriginOf(taught, 2, machine.lenses(1).name()), own);
  const Vec3 p(10, 10, 50), near = Vec3::Zero();
  EXPECT_LT(
      (AxesFromGlassOf(FrozenOn(taught, 2)).ToAxes(p, near).value() -
       AxesFromGlassOf(FrozenOn(machine, 2)).ToAxes(p, near).value() - Vec3(1, 2, 3))
          .norm(),
      1e-12);
  EXPECT_EQ(AxesFromGlassOf(FrozenOn(taught, 1)).ToAxes(p, near).value(),
            AxesFromGlassOf(FrozenOn(machine, 1)).ToAxes(p, near).value());
}

TEST(Teaching, OnlyTheChosenAxesOfAZeroAreSet) {
  const MachineSpec machine = GoodMachine();
  ZeroChoice choice;
  choice.lens = machine.lenses(0).name();
  choice.sets = {false, false, true};
  const MachineSpec taught = With(machine, WithZero(machine, Vec3(5, 6, 7), choice));
  const Vec3 own = Vec3Of(machine.block_origin_mm());
  EXPECT_EQ(BlockOriginOf(taught, 1, choice.lens), Vec3(own.x(), own.y(), 7));
}

TEST(Teaching, UnknownLensesAndChannelsAreRefusedWithWhatThereIs) {
  const MachineSpec machine = GoodMachine();
  ZeroChoice choice;
  choice.lens = "f999";
  EXPECT_THAT(WithZero(machine, Vec3::Zero(), choice).error().message,
              AllOf(HasSubstr("f999"), HasSubstr(machine.lenses(0).name())));
  choice.lens.clear();
  EXPECT_THAT(WithZero(machine, Vec3::Zero(), choice).error().message,
              HasSubstr("several lenses"));
  choice = {9, machine.lenses(0).name()};
  EXPECT_THAT(WithZero(machine, Vec3::Zero(), choice).error().message,
              HasSubstr("channel 9"));
  EXPECT_THAT(
      WithZero(machine, Vec3(0, 0, 1e6), {1, machine.lenses(0).name()}).error().message,
      HasSubstr("taught.zeros[0].block_origin_mm.z"));
}

TEST(Teaching, SoftLimitsNarrowTheTravelOfJobsAndOfTaughtPlaces) {
  const MachineSpec machine = GoodMachine();
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const Box3 soft{travel.min_mm + Vec3(10, 0, 0), travel.max_mm - Vec3(0, 10, 0)};
  const MachineSpec taught = With(machine, WithSoftLimits(machine, soft));
  EXPECT_EQ(AxisLimitsOf(taught).travel_mm.min_mm, soft.min_mm);
  EXPECT_EQ(AxisLimitsOf(taught).travel_mm.max_mm, soft.max_mm);
  EXPECT_THAT(WithPark(taught, travel.min_mm).error().message,
              AllOf(HasSubstr("taught.park, axis x"), HasSubstr("outside the limits")));
  EXPECT_TRUE(WithSample(taught, soft.min_mm));
  EXPECT_THAT(WithSoftLimits(machine, Box3{travel.min_mm - Vec3(1, 0, 0), travel.max_mm})
                  .error()
                  .message,
              HasSubstr("not within the axis' travel"));
  EXPECT_FALSE(WithSoftLimits(machine, Box3{soft.max_mm, soft.min_mm}));
  const auto wide = WithSoftLimits(taught, std::nullopt);
  ASSERT_TRUE(wide);
  EXPECT_FALSE(wide->has_limits());
}

TEST(Teaching, ModelsInChannelsOfDifferentZerosAreRefused) {
  MachineSpec machine = GoodMachine();
  machine.mutable_laser()->set_channels(2);
  JobSpec job = GoodJob();
  job.mutable_laser()->add_channels(1);
  job.mutable_laser()->add_channels(2);
  const auto has_finding = [&](const MachineSpec& on) {
    for (const Finding& finding : CheckJobOnMachine(job, on, kRatio)) {
      if (finding.message.find("has a zero that is") != std::string::npos) return true;
    }
    return false;
  };
  EXPECT_FALSE(has_finding(machine));
  const double tolerance_mm = 1e-3 * machine.position_tolerance_um();
  const ZeroChoice choice{2, machine.lenses(0).name()};
  EXPECT_FALSE(has_finding(
      With(machine, WithZeroMoved(machine, Vec3(0.9 * tolerance_mm, 0, 0), choice))));
  EXPECT_TRUE(has_finding(
      With(machine, WithZeroMoved(machine, Vec3(1.1 * tolerance_mm, 0, 0), choice))));
}

}  // namespace
}  // namespace intaglio
