#include "services/client/machine/test_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/models/job_cloud.h"
#include "services/job/models/text_model.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TestGrid OnEls() {
  TestGrid grid;
  grid.machine_file = INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";
  grid.glass = "N-BK7";
  return grid;
}

struct Made {
  JobSpec job;
  PointCloud cloud;
};

/// The points of one of its jobs.
Made MakeFile(const TestGrid& grid, const std::filesystem::path& file) {
  const MachineSpec machine = ReadMachineFile(grid.machine_file).value();
  JobSpec job = ReadJobFile(file).value();
  EXPECT_TRUE(ResolveFonts(job).empty());
  job = WithDefaults(job, machine);
  auto cloud = MakeJobCloud(job, {}, {}, {});
  EXPECT_TRUE(cloud) << cloud.error().message;
  return {job, std::move(cloud->cloud)};
}

Made MakeOf(const TestGrid& grid) {
  const auto files = WriteTestGrid(grid, test::FreshFolder());
  EXPECT_TRUE(files) << files.error().message;
  EXPECT_EQ(files->size(), 1u);
  return MakeFile(grid, files->front());
}

// Nearest distances of a patch are its column's spacing; its energy is its row's.
TEST(TestGrid, RowsHaveTheirEnergiesAndColumnsTheirSpacings) {
  TestGrid grid = OnEls();
  grid.energies_mj = {10, 20, 30};
  grid.spacings_mm = {0.1, 0.2};
  const Made made = MakeOf(grid);
  std::map<std::uint32_t, PointList> patches;
  for (std::size_t i = 0; i < made.cloud.size(); ++i) {
    const Model& model = made.job.models(static_cast<int>(made.cloud.source[i]));
    if (!model.has_text())
      patches[made.cloud.source[i]].push_back(made.cloud.points_mm[i]);
  }
  ASSERT_EQ(patches.size(), 6u);
  std::map<double, std::set<double>> heights_of_energy, places_of_spacing;
  for (const auto& [source, points_mm] : patches) {
    const Model& model = made.job.models(static_cast<int>(source));
    const double spacing_mm = model.curves().distance_mm();
    double nearest_mm = 100;
    for (std::size_t i = 0; i < points_mm.size(); i += 7)
      for (std::size_t j = 0; j < points_mm.size(); ++j)
        if (i != j)
          nearest_mm = std::min(nearest_mm, (points_mm[i] - points_mm[j]).norm());
    EXPECT_GE(nearest_mm, 0.999 * 0.1);
    // 4 mm by 4 mm; a hexagonal lattice has 2 / sqrt(3) points a square of the spacing.
    const double squares = 16 / (spacing_mm * spacing_mm);
    EXPECT_GT(static_cast<double>(points_mm.size()), 0.8 * squares);
    EXPECT_LT(static_cast<double>(points_mm.size()), 1.4 * squares);
    Box3 box;
    for (const Vec3& p : points_mm) box.Extend(p);
    EXPECT_NEAR(box.size_mm().x(), 4, 0.01);
    EXPECT_NEAR(box.size_mm().z(), 4, 0.01);
    heights_of_energy[model.pulse_energy_mj()].insert(std::round(box.center_mm().z()));
    places_of_spacing[spacing_mm].insert(std::round(box.center_mm().x()));
  }
  ASSERT_EQ(heights_of_energy.size(), 3u);
  for (const auto& [energy, heights] : heights_of_energy) EXPECT_EQ(heights.size(), 1u);
  EXPECT_LT(*heights_of_energy[10].begin(), *heights_of_energy[30].begin());
  EXPECT_LT(*places_of_spacing[0.1].begin(), *places_of_spacing[0.2].begin());
  std::vector<std::string> labels;
  for (const Model& model : made.job.models())
    if (model.has_text()) labels.push_back(model.text().text());
  EXPECT_THAT(labels, ElementsAre("10 mJ", "20 mJ", "30 mJ", "0.1", "0.2"));
}

TEST(TestGrid, DefaultsAreTheMachinesEnergiesAndTheLensesCrack) {
  const Made made = MakeOf(OnEls());
  std::set<double> energies, spacings;
  for (const Model& model : made.job.models()) {
    if (model.has_text()) continue;
    energies.insert(model.pulse_energy_mj());
    spacings.insert(model.curves().distance_mm());
  }
  EXPECT_EQ(energies.size(), 4u);
  EXPECT_EQ(*energies.rbegin(), 30);
  EXPECT_EQ(spacings.size(), 4u);
}

// Each job has its pulses and its place in the one block, beside that of the job before.
TEST(TestGrid, EachNumberOfPulsesIsAJobOfItsOwnInTheSameBlock) {
  TestGrid grid = OnEls();
  grid.machine_file = INTAGLIO_SOURCE_DIR "/deploy/machines/bjjcz-glass.textproto";
  grid.energies_mj = {0.06, 0.08};
  grid.spacings_mm = {0.2};
  grid.pulses = {8, 24};
  const auto files = WriteTestGrid(grid, test::FreshFolder());
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_EQ(files->size(), 2u);
  double end_mm = 0;
  for (std::size_t column = 0; column < files->size(); ++column) {
    const Made made = MakeFile(grid, (*files)[column]);
    EXPECT_EQ(static_cast<int>(made.job.laser().pulses_per_point()), grid.pulses[column]);
    std::set<double> energies;
    Box3 patches;
    for (std::size_t i = 0; i < made.cloud.size(); ++i) {
      const Model& model = made.job.models(static_cast<int>(made.cloud.source[i]));
      if (model.has_text()) continue;
      energies.insert(model.pulse_energy_mj());
      patches.Extend(made.cloud.points_mm[i]);
    }
    EXPECT_EQ(energies, (std::set<double>{0.06, 0.08}));
    EXPECT_GT(patches.min_mm.x(), end_mm + 1.5);
    end_mm = patches.max_mm.x();
  }
  grid.spacings_mm = {0.1, 0.2};
  EXPECT_EQ(WriteTestGrid(grid, test::FreshFolder()).error().code,
            ErrorCode::kInvalidValue);
}

TEST(TestGrid, RefusesWhatHasNoPlace) {
  TestGrid grid = OnEls();
  grid.block_mm = Vec3(20, 20, 20);
  const auto small = WriteTestGrid(grid, test::FreshFolder());
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(small.error().message, HasSubstr("needs a block"));
  grid.block_mm.reset();
  grid.patch_mm = 0.5;
  EXPECT_EQ(WriteTestGrid(grid, test::FreshFolder()).error().code,
            ErrorCode::kInvalidValue);
}

}  // namespace
}  // namespace intaglio::client
