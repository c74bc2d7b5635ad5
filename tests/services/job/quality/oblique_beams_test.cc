#include "services/job/quality/oblique_beams.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "engrave/optics/focus.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kIndex = 1.519473;

/// A cube of 60 mm under the lens of the supplied profile, with these energies.
FrozenJob CubeJob(double energy_mj, double crack_energy_mj) {
  FrozenJob job;
  MachineSpec& machine = *job.mutable_machine();
  machine = ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-glass.textproto")
                .value();
  machine.mutable_head_over_block()->set_pupil_y_mm(140);
  machine.mutable_head_over_block()->set_crack_energy_mj(crack_energy_mj);
  JobSpec spec = GoodJob();
  spec.clear_lens();
  spec.clear_laser();
  spec.mutable_laser()->set_pulse_energy_mj(energy_mj);
  Vector3& size_mm = *spec.mutable_block()->mutable_size_mm();
  size_mm.set_x(60);
  size_mm.set_y(60);
  size_mm.set_z(60);
  *job.mutable_job() = WithDefaults(spec, machine);
  job.mutable_optics()->set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(kIndex, 0.03));
  return job;
}

/// Points of one model on a line in +x from under the axis, at a depth.
PointList Line(double depth_mm) {
  PointList points_mm;
  for (double x = 30; x < 60; x += 0.1) points_mm.emplace_back(x, 30, 60 - depth_mm);
  return points_mm;
}

// 60 mm deep, NA 0.03: 0.949 of the intensity are left at 4 degrees, 0.532 at 8, as of a
// sum of plane waves by another program.
TEST(ObliqueBeams, TheUsableRadiusIsThatOfTheIntensity) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  for (const auto& [ratio, degrees] : {std::pair{0.949, 4.0}, std::pair{0.532, 8.0}}) {
    FrozenJob job = CubeJob(0.2, 0.2 * ratio);
    job.mutable_job()->mutable_laser()->set_energy_by_place(false);
    const auto figures = ObliqueFiguresOf(job, points_mm, source);
    ASSERT_TRUE(figures);
    const double radius_mm = 140 * std::tan(degrees * std::numbers::pi / 180);
    EXPECT_NEAR(figures->radii.back().radius_mm, radius_mm, 0.25);
    EXPECT_NEAR(figures->radii.back().depth_mm, 60, 1e-9);
    EXPECT_GT(figures->radii.back().max_radius_mm, radius_mm + 1) << "0.3 mJ at most";
    EXPECT_GT(figures->radii.front().radius_mm, 2 * radius_mm) << "near the face";
    // Every tenth of a millimetre beyond it is a point without a crack.
    EXPECT_NEAR(static_cast<double>(figures->weak.count), 10 * (30 - radius_mm), 4);
    EXPECT_NEAR(figures->weak.first_mm.x() - 30, radius_mm, 0.35);
  }
}

TEST(ObliqueBeams, WarnsWithCountPlaceAndRemedy) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  const FrozenJob job = CubeJob(0.2, 0.1);
  const auto figures = ObliqueFiguresOf(job, points_mm, source);
  ASSERT_TRUE(figures);
  const Warnings warnings = ObliqueWarningsOf(*figures);
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_EQ(warnings[0].code, WarningCode::kObliqueBeam);
  EXPECT_EQ(warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(warnings[0].text, HasSubstr("points get no crack, the first at ("));
  EXPECT_THAT(warnings[0].text, HasSubstr("mm from the axis of the lens"));
  EXPECT_EQ(warnings[1].code, WarningCode::kTwoFoci);
  // D > 2.83 Rayleigh ranges, 0.81 mm: beyond 8.8 degrees.
  EXPECT_NEAR(figures->radii.back().double_radius_mm, 21.6, 0.4);
}

TEST(ObliqueBeams, EnoughEnergyOrAnUprightBeamLosesNothing) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  const FrozenJob strong = CubeJob(0.3, 0.02);
  EXPECT_EQ(ObliqueFiguresOf(strong, points_mm, source)->weak.count, 0u);
  FrozenJob straight = CubeJob(0.2, 0.2);
  straight.mutable_machine()->mutable_head_over_block()->clear_pupil_x_mm();
  straight.mutable_machine()->mutable_head_over_block()->clear_pupil_y_mm();
  const auto figures = ObliqueFiguresOf(straight, points_mm, source);
  EXPECT_EQ(figures->weak.count, 0u);
  EXPECT_EQ(figures->weakest_ratio, 1);
  EXPECT_THAT(ObliqueWarningsOf(*figures), IsEmpty());
}

// The same line: by place all points are as strong as 0.2 mJ upright, or have 0.3 mJ.
TEST(ObliqueBeams, TheEnergyFollowsThePlaceUpToTheLasers) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  FrozenJob job = CubeJob(0.2, 0.1);
  const auto raised = ObliqueFiguresOf(job, points_mm, source);
  ASSERT_TRUE(raised);
  EXPECT_EQ(raised->energies_mj.front(), 0.2);
  EXPECT_EQ(raised->energies_mj.back(), 0.3);
  EXPECT_GT(raised->limited_count, 0u);
  EXPECT_EQ(raised->weak.count, raised->beyond.count) << "nothing else lacks a crack";
  const Status refused = CheckOblique(job, *raised);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message,
              HasSubstr("mm from the axis of the lens at 60 mm"));
  job.mutable_job()->mutable_laser()->set_energy_by_place(false);
  const auto flat = ObliqueFiguresOf(job, points_mm, source);
  EXPECT_GT(flat->weak.count, raised->weak.count);
  EXPECT_TRUE(CheckOblique(job, *flat)) << "these energies are tried";
}

// Nobody knows then what needs more than the laser has: a warning says what is assumed.
TEST(ObliqueBeams, WithoutAMeasuredCrackEnergyNothingIsRefused) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  FrozenJob job = CubeJob(0.3, 0.1);
  job.mutable_machine()->mutable_head_over_block()->clear_crack_energy_mj();
  const auto figures = ObliqueFiguresOf(job, points_mm, source);
  ASSERT_GT(figures->beyond.count, 0u);
  EXPECT_TRUE(CheckOblique(job, *figures));
  const Warnings warnings = ObliqueWarningsOf(*figures);
  ASSERT_FALSE(warnings.empty());
  EXPECT_THAT(warnings.front().text, HasSubstr("give head_over_block.crack_energy_mj"));
}

TEST(ObliqueBeams, ADriverThatCannotVaryTheEnergyIsNamed) {
  const PointList points_mm = Line(60);
  const std::vector<std::uint32_t> source(points_mm.size(), 0);
  FrozenJob job = CubeJob(0.3, 0.1);
  job.mutable_machine()->mutable_laser_line()->set_protocol("motion-output");
  const auto figures = ObliqueFiguresOf(job, points_mm, source);
  EXPECT_EQ(figures->energies_mj.size(), 1u);
  const Status refused = CheckOblique(job, *figures);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("cannot vary it"));
}

TEST(ObliqueBeams, AStageHasNone) {
  FrozenJob job = CubeJob(0.2, 0.1);
  job.mutable_machine()->clear_head_over_block();
  EXPECT_FALSE(ObliqueFiguresOf(job, Line(60), {}));
  EXPECT_THAT(ObliqueNotesOf(job.machine()), IsEmpty());
}

TEST(ObliqueBeams, NotesNameTheRadiusByDepthOfEachLens) {
  const auto notes = ObliqueNotesOf(CubeJob(0.2, 0.1).machine());
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0], HasSubstr("lens f100: "));
  EXPECT_THAT(notes[0], HasSubstr("at 5 mm depth"));
  EXPECT_THAT(notes[0], HasSubstr("at 60 mm depth"));
}

}  // namespace
}  // namespace intaglio
