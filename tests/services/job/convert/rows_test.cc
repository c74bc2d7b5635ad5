#include "services/job/convert/rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

MachineSpec PolarMachine(double x_mm, double y_mm) {
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value();
  machine.mutable_block_origin_mm()->set_x(x_mm);
  machine.mutable_block_origin_mm()->set_y(y_mm);
  return machine;
}

JobSpec JobInRows(double distance_mm) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->set_file("cube.stl");
  job.mutable_models(0)->mutable_solid()->set_distance_mm(distance_mm);
  job.mutable_discretization()->set_min_spacing_mm(0.3);
  job.mutable_discretization()->set_height_ratio(1.5);
  job.mutable_laser()->Clear();
  job.mutable_ordering()->mutable_boustrophedon();
  return job;
}

FrozenJob WithRows(const JobSpec& job, const MachineSpec& machine) {
  FrozenJob frozen;
  *frozen.mutable_machine() = machine;
  *frozen.mutable_job() = WithDefaults(job, machine);
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.65);
  return frozen;
}

/// How fast the focus goes in the middle of the block, by a small step of the axes there.
double SpeedAlong(const FrozenJob& job, double turn_deg) {
  constexpr double kStepMm = 1e-4;
  const double turn_rad = turn_deg * std::numbers::pi / 180;
  const auto axes = machine::AxesAlong(
      AxesFromGlassOf(job),
      {Vec3(25, 25, 15),
       Vec3(25, 25, 15) + kStepMm * Vec3(std::cos(turn_rad), std::sin(turn_rad), 0)},
      AxisLimitsOf(job.machine()).travel_mm);
  const Vec3 times_s = (axes.value()[1] - axes.value()[0])
                           .cwiseAbs()
                           .cwiseQuotient(AxisLimitsOf(job.machine()).max_speed_mm_s);
  return kStepMm / times_s.maxCoeff();
}

TEST(Rows, AreThoseOfTheLatticeOfSolids) {
  const JobSpec solid = WithDefaults(JobInRows(0.4), GoodMachine());
  EXPECT_NEAR(solid.ordering().boustrophedon().layer_thickness_mm(),
              1.5 * 0.4 * 0.816496580927726, 1e-12);
  EXPECT_NEAR(solid.ordering().boustrophedon().row_width_mm(), 0.4 * 0.866025403784439,
              1e-12);
  JobSpec given = JobInRows(0.4);
  given.mutable_ordering()->mutable_boustrophedon()->set_row_width_mm(0.7);
  EXPECT_EQ(WithDefaults(given, GoodMachine()).ordering().boustrophedon().row_width_mm(),
            0.7);
}

TEST(Rows, AreByTheSpacingWhereThereIsNoLattice) {
  JobSpec thinned = JobInRows(0.25), surface = JobInRows(0.4), two = JobInRows(0.4);
  surface.mutable_models(0)->mutable_fill();
  *two.add_models() = two.models(0);
  ASSERT_EQ(FindLatticeDistance(two), 0.4);
  two.mutable_models(1)->mutable_solid()->set_distance_mm(0.5);
  for (const JobSpec& job : {thinned, surface, two}) {
    EXPECT_EQ(FindLatticeDistance(job), std::nullopt);
    const BoustrophedonOrder rows =
        WithDefaults(job, GoodMachine()).ordering().boustrophedon();
    EXPECT_EQ(rows.layer_thickness_mm(), 0.3);
    EXPECT_EQ(rows.row_width_mm(), 0.3);
  }
}

TEST(Rows, AreAlongXOnLinearAxes) {
  MachineSpec fast_in_y = GoodMachine();
  fast_in_y.mutable_y()->set_max_speed_mm_s(300);
  for (const MachineSpec& machine : {GoodMachine(), fast_in_y})
    EXPECT_EQ(DefaultRowTurnDeg(WithRows(JobInRows(0.4), machine)), 0);
}

// Wherever the block lies on the table, by trial of all rows of the lattice.
TEST(Rows, AreInTheDirectionInWhichAnArmAndATableAreFastest) {
  JobSpec surface = JobInRows(0.4);
  surface.mutable_models(0)->mutable_fill();
  std::vector<double> chosen_deg;
  for (const auto& [x_mm, y_mm] :
       {std::pair(-25.0, 90.0), {-120.0, 50.0}, {60.0, 40.0}, {70.0, -70.0}}) {
    const MachineSpec machine = PolarMachine(x_mm, y_mm);
    for (const JobSpec& job : {JobInRows(0.4), surface}) {
      const FrozenJob frozen = WithRows(job, machine);
      const double turn_deg = DefaultRowTurnDeg(frozen);
      const std::vector<double> turns_deg = FindLatticeDistance(frozen.job())
                                                ? std::vector<double>{0, 60, 120}
                                                : std::vector<double>{0, 90};
      EXPECT_EQ(turn_deg,
                *std::ranges::max_element(
                    turns_deg, {}, [&](double deg) { return SpeedAlong(frozen, deg); }))
          << x_mm;
      EXPECT_NEAR(GlassLimitsAlong(frozen, turn_deg * std::numbers::pi / 180).speed_mm_s,
                  SpeedAlong(frozen, turn_deg), 1e-3);
      EXPECT_NEAR(OrderOptionsOf(frozen).boustrophedon.row_turn_rad,
                  turn_deg * std::numbers::pi / 180, 1e-12);
      chosen_deg.push_back(turn_deg);
    }
  }
  for (const double deg : {0, 60, 120, 90})
    EXPECT_TRUE(std::ranges::count(chosen_deg, deg)) << deg << " is never the fastest";
}

TEST(Rows, AreInTheDirectionThatTheJobNames) {
  JobSpec job = JobInRows(0.4);
  job.mutable_ordering()->mutable_boustrophedon()->set_row_turn_deg(-180);
  EXPECT_NEAR(
      OrderOptionsOf(WithRows(job, PolarMachine(-25, 90))).boustrophedon.row_turn_rad,
      -std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace intaglio
