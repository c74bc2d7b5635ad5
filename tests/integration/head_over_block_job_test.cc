// Whole jobs at a scan head over a block: a cube of 50 mm, 5 to 55 mm below the face of
// N-BK7. The virtual glass head has a ray trace of its own; where cracks are is read from
// its glass and compared with the points of the file, without the product's proof.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "tests/engrave/galvo/files/written_corrections.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using testing::Program;
using testing::RunJob;
using testing::Running;

constexpr int kPerEdge = 14;
constexpr double kBlockMm = 60, kEdgeMm = 50;
constexpr double kCrackLengthMm = 0.15;  // of the lens of the profile

/// How far cracks are from their points at most, mm.
struct Misses {
  double across_mm = 0, depth_mm = 0;
  std::size_t cracks = 0;
};

class HeadOverBlockJob : public RunJob {
 protected:
  HeadOverBlockJob() { MakeCube(kPerEdge); }
  /// galvo-glass with one text in the place of another.
  std::string ProfileWith(const std::string& replaced, const std::string& by,
                          const std::string& of_head = "") const {
    std::string text = testing::TextIn(fs::path(INTAGLIO_SOURCE_DIR) /
                                       "deploy/machines/galvo-glass.textproto");
    EXPECT_NE(text.find(replaced), std::string::npos) << replaced;
    text.replace(text.find(replaced), replaced.size(), by);
    const std::string begin = "head_over_block {\n";
    text.insert(text.find(begin) + begin.size(), of_head);
    std::ofstream(folder_ / "machine.textproto") << text;
    return (folder_ / "machine.textproto").string();
  }
  /// The corners need ten times the energy of the supplied laser.
  static constexpr const char* kEnergy = "pulse_energy_mj: 0.3";
  static constexpr const char* kStrong = "pulse_energy_mj: 3";

  Ended RunOn(const std::string& machine, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"--lockstep", "--warm-up",
                                      "0",          "--machine",
                                      machine,      "--no-record",
                                      "--block",    "60",
                                      "60",         "60",
                                      "--set",      "glass=N-BK7",
                                      "--set",      "block.margin_mm=2"};
    words.insert(words.end(), more.begin(), more.end());
    Running run(Program("intaglio"), Arguments(words, folder_ / "cube.xyz"),
                folder_ / "output.txt");
    return run.WaitForEnd(3 * testing::kBound);
  }
  /// A cube of so many points an edge.
  void MakeCube(int per_edge) {
    points_mm_.clear();
    std::ofstream cube(folder_ / "cube.xyz");
    for (int i = 0; i < per_edge * per_edge * per_edge; ++i) {
      const Vec3 share(i % per_edge, i / per_edge % per_edge, i / per_edge / per_edge);
      points_mm_.push_back(Vec3::Constant((kBlockMm - kEdgeMm) / 2) +
                           kEdgeMm / (per_edge - 1) * share);
      cube << points_mm_.back().transpose() << "\n";
    }
  }
  /// The nearest crack counts for each point; they are 3.8 mm apart.
  Misses Missed() const {
    Misses misses;
    const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
    if (!glass) return misses;
    for (const auto& crack : glass->cracks) {
      if (!crack.in_glass) continue;
      ++misses.cracks;
      const auto nearest = std::ranges::min_element(
          points_mm_, {},
          [&](const Vec3& point) { return (point - crack.position_mm).squaredNorm(); });
      const Vec3 away_mm = crack.position_mm - *nearest;
      misses.across_mm =
          std::max(misses.across_mm, away_mm.head<2>().cwiseAbs().maxCoeff());
      misses.depth_mm = std::max(misses.depth_mm, std::abs(away_mm.z()));
    }
    return misses;
  }

  PointList points_mm_;
};

TEST_F(HeadOverBlockJob, EachCrackOfACubeIsInItsPlace) {
  const Ended run = RunOn(ProfileWith(kEnergy, kStrong));
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  // It warns of points with two foci.
  EXPECT_EQ(Report().verdict().kind(), "good_with_warnings");
  const Misses misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size());
  EXPECT_LT(misses.across_mm, 0.010);
  EXPECT_LT(misses.depth_mm, kCrackLengthMm / 10);
}

// Points at a height of their own each: z sweeps past them, and each crack is within the
// tolerance that the job states; exact heights take many times the ticks.
TEST_F(HeadOverBlockJob, EachCrackIsWithinItsToleranceOfDepthWhileZSweeps) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  points_mm_.clear();
  std::ofstream scatter(folder_ / "cube.xyz");
  while (points_mm_.size() < 500) {
    const Vec3 point(20 + 20 * unit(random), 20 + 20 * unit(random), 20 + unit(random));
    if (std::ranges::any_of(points_mm_, [&](const Vec3& other) {
          return (other - point).norm() < 0.2;
        })) {
      continue;
    }
    points_mm_.push_back(point);
    scatter << fmt::format("{:.6f} {:.6f} {:.6f}\n", point.x(), point.y(), point.z());
  }
  scatter.close();
  constexpr double kToleranceMm = 0.05, kRestMm = 0.005;  // aberration and lag
  const std::string machine = ProfileWith(kEnergy, kStrong);
  const Ended swept = RunOn(machine, {"--set", "motion.depth_tolerance_um=50"});
  ASSERT_TRUE(swept.in_time);
  ASSERT_EQ(swept.exit_code, 0) << swept.output;
  const Misses misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size());
  EXPECT_LT(misses.across_mm, 0.010);
  EXPECT_LT(misses.depth_mm, kToleranceMm + kRestMm);
  EXPECT_GT(misses.depth_mm, kToleranceMm / 2) << "the tolerance was used";
  EXPECT_EQ(Report().shadow_violations(), 0u);
  EXPECT_GT(Report().utilisation(), 0.2);
}

// A beam that is taken for upright is beside its point by h tan^3 (1 - 1/n^2) / 2 at the
// corner, 165 um of a pupil at 140 mm (117 um along each axis), and 2.0 mm too deep.
TEST_F(HeadOverBlockJob, WithoutThePupilItIsMillimetresTooDeep) {
  std::string machine = ProfileWith("  pupil_x_mm: 140\n  pupil_y_mm: 135\n", "");
  std::string text = testing::TextIn(machine);
  const std::string energy = kEnergy;
  text.replace(text.find(energy), energy.size(), kStrong);
  std::ofstream(machine) << text;
  std::ofstream(folder_ / "truth.textproto")
      << "stage { positioner { mirrors { pupil_x_mm: 140 pupil_y_mm: 140 } } }\n";
  const Ended run = RunOn(machine, {"--truth", (folder_ / "truth.textproto").string()});
  ASSERT_TRUE(run.in_time);
  const Misses misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size()) << run.output;
  // Tolerances: those of the lag and of the aberration of the wide beam.
  EXPECT_NEAR(misses.across_mm, 0.117, 0.010);
  EXPECT_NEAR(misses.depth_mm, 1.997, 0.030);
}

// A lens that puts the beam up to 0.13 mm too far out, and the file that makes up for it,
// with half a unit of 0.6 um on each axis. Without the file it is as wrong as the field.
TEST_F(HeadOverBlockJob, ACorrectionFilePutsEachCrackInItsPlace) {
  const galvo::WrongField field{0.03};
  std::ofstream(folder_ / "head.cor", std::ios::binary) << galvo::CorBytes(field, 80);
  std::ofstream(folder_ / "truth.textproto")
      << "stage { positioner { mirrors { deviations { pitch_mm: 40 nodes_a_side: 2 "
         "x_nm: [0, 0, 0, 0] y_nm: [0, 0, 0, 0] } distortion_ratio: 0.03 } } }\n";
  const std::vector<std::string> in_this_field = {"--truth",
                                                  (folder_ / "truth.textproto").string()};
  MakeCube(4);
  const std::string with =
      ProfileWith(kEnergy, kStrong, "  correction_file: \"head.cor\"\n");
  const Ended run = RunOn(with, in_this_field);
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  Misses misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size());
  EXPECT_LT(misses.across_mm, 0.010);
  EXPECT_LT(misses.depth_mm, kCrackLengthMm / 10);
  const Ended wrong = RunOn(ProfileWith(kEnergy, kStrong), in_this_field);
  ASSERT_TRUE(wrong.in_time);
  misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size()) << wrong.output;
  // At the corners; the larger of both axes counts.
  const Vec2 corner_mm = Vec2::Constant(kEdgeMm / 2);
  EXPECT_NEAR(misses.across_mm, field.CorrectionAt(corner_mm).cwiseAbs().maxCoeff(),
              0.012);
}

// The virtual glass head has the field that the file makes up for, unless a truth file
// gives it another.
TEST_F(HeadOverBlockJob, TheVirtualHeadHasTheFieldOfTheCorrectionFile) {
  std::ofstream(folder_ / "head.cor", std::ios::binary) << galvo::CorBytes({-0.04}, 80);
  MakeCube(3);
  const Ended run =
      RunOn(ProfileWith(kEnergy, kStrong, "  correction_file: \"head.cor\"\n"));
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Misses misses = Missed();
  EXPECT_EQ(misses.cracks, points_mm_.size());
  EXPECT_LT(misses.across_mm, 0.010);
  EXPECT_LT(misses.depth_mm, kCrackLengthMm / 10);
}

// The supplied laser is too weak for the deep corners: they are named before, and the
// glass has no crack there.
TEST_F(HeadOverBlockJob, BeyondTheUsableRadiusThereIsNoCrack) {
  // Deepest first, the corners come in a row: else the machine waits for a person.
  const Ended run =
      RunOn(ProfileWith(kEnergy, kEnergy + std::string("\n  max_missed_in_a_row: 1000")),
            {"--set", "laser.energy_by_place=false"});
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0) << "not good";
  EXPECT_NE(run.output.find("points get no crack"), std::string::npos) << run.output;
  const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
  ASSERT_TRUE(glass.has_value());
  EXPECT_EQ(glass->cracks.size(), points_mm_.size());
  std::size_t missed = 0;
  for (const auto& crack : glass->cracks) {
    if (crack.in_glass) continue;
    ++missed;
    const Vec3 axis_mm(kBlockMm / 2, kBlockMm / 2, crack.position_mm.z());
    EXPECT_GT((crack.position_mm - axis_mm).norm(), 25);
  }
  EXPECT_GT(missed, 0u);
  EXPECT_EQ(Report().points().missed(), missed);
}

TEST_F(HeadOverBlockJob, WhatNoEnergyCracksIsRefusedWithTheUsableRadius) {
  const Ended run = RunOn(ProfileWith(kEnergy, kEnergy));
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0);
  EXPECT_NE(run.output.find("mm from the axis of the lens at 55 mm depth"),
            std::string::npos)
      << run.output;
  EXPECT_FALSE(fs::exists(folder_ / "out/glass.ply")) << "nothing is engraved";
}

// 0.3 mJ are too little for the corners (above); a laser that has more raises them there.
TEST_F(HeadOverBlockJob, EnergyByPlaceCracksWhatOneEnergyDoesNot) {
  const Ended run =
      RunOn(ProfileWith(kEnergy, kStrong), {"--set", "laser.pulse_energy_mj=0.3"});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(Missed().cracks, points_mm_.size());
  EXPECT_GT(Report().pulse_energies_size(), 10);
}

}  // namespace
}  // namespace intaglio
