// The round of a calibration through the driver and the virtual head alone, without
// processes: circles of a grid are burnt, their places get the noise of a camera, the fit
// makes a board's file, and with it circles are burnt at the nodes and between them.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "engrave/galvo/calibration_grid.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/galvo/head_fit.h"
#include "tests/services/drivers/galvo/head_bench.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

constexpr double kWideFieldMm = 100, kBorderAngleRad = 20 * std::numbers::pi / 180;
constexpr int kTableBits = 5243, kTableNodes = 129;

/// Where circles around these places come to lie: by the energy that was burnt.
std::vector<Vec2> MiddlesBurnt(const std::vector<Vec2>& places_mm,
                               const std::string& correction_file) {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_correction_file(correction_file);
  auto truth = HeadTruthOf(machine);
  truth.physics.half_angle_rad = kBorderAngleRad;
  truth.physics.lens_ratio = 0.03;
  HeadBench bench(machine, truth);
  EXPECT_TRUE(bench.Connect());
  mark::MarkSet set{{{"pen", 1000, 0.5, 0, 1, 0, 0}}, {}};
  for (const Vec2& place_mm : places_mm) set.marks.push_back(CircleMark(place_mm, 0.3));
  bench.Run(1, set);
  EXPECT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
  EXPECT_EQ(bench.state().fault, "");
  std::map<std::uint32_t, std::pair<Vec2, double>> sums;
  for (const formats::BurntTick& tick : bench.Burnt()) {
    auto [sum, first] = sums.try_emplace(tick.mark, Vec2::Zero(), 0);
    sum->second.first += tick.energy_mj * (tick.place_mm - tick.way_mm / 2);
    sum->second.second += tick.energy_mj;
  }
  EXPECT_EQ(sums.size(), places_mm.size());
  std::vector<Vec2> burnt_mm;
  for (const auto& [mark, sum] : sums) burnt_mm.emplace_back(sum.first / sum.second);
  return burnt_mm;
}

double WorstOfUm(const std::vector<Vec2>& places_mm, const std::vector<Vec2>& burnt_mm) {
  double worst_mm = 0;
  for (std::size_t i = 0; i < places_mm.size(); ++i)
    worst_mm = std::max(worst_mm, (burnt_mm[i] - places_mm[i]).norm());
  return 1000 * worst_mm;
}

/// The correction by places with noise, as a file.
std::string FittedTable(const std::vector<Vec2>& commands_mm,
                        const std::vector<Vec2>& burnt_mm, double noise_mm) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, noise_mm);
  std::vector<galvo::GridMark> marks;
  for (std::size_t i = 0; i < commands_mm.size(); ++i)
    marks.push_back({commands_mm[i], burnt_mm[i] + Vec2(noise(random), noise(random))});
  const auto fit =
      galvo::FitHead(marks, {kWideFieldMm, kWideFieldMm / 2 / kBorderAngleRad});
  EXPECT_TRUE(fit.has_value());
  const auto spline = galvo::Interpolation::kSpline;
  const auto deviations =
      galvo::CorrectionTable::Make(galvo::DeviationsOf(*fit, kWideFieldMm, kTableNodes),
                                   spline)
          .value();
  const auto commands = galvo::CorrectionTable::Make(
                            galvo::CommandGrid(deviations, kTableNodes).value(), spline)
                            .value();
  const auto file = test::FreshFolder() / "head.ct5";
  std::ofstream(file, std::ios::binary)
      << galvo::WriteCt5(galvo::Ct5Of(commands, kTableBits, nullptr).value());
  return file;
}

TEST(GalvoCalibration, TheSecondRoundIsBelowTenMicrometresBetweenTheNodesToo) {
  const auto grid_mm = galvo::CalibrationGrid(9, 12);
  const auto first_mm = MiddlesBurnt(grid_mm, "");
  EXPECT_GT(WorstOfUm(grid_mm, first_mm), 2000);
  const auto dense_mm = galvo::CalibrationGrid(17, 6);
  // Steps of the outputs are 1.5 um, circles lie within 1 um of their middles.
  EXPECT_LT(
      WorstOfUm(dense_mm, MiddlesBurnt(dense_mm, FittedTable(grid_mm, first_mm, 0))), 3);
  EXPECT_LT(
      WorstOfUm(dense_mm, MiddlesBurnt(dense_mm, FittedTable(grid_mm, first_mm, 0.005))),
      10);
}

}  // namespace
}  // namespace intaglio::drivers
