// Orders for arm and rotary table (Trochimczuk 2008 ch. 8.3). In scenario 1 the arm
// sweeps while the table rests, and the table indexes from sweep to sweep; in scenario 2
// the table turns and the arm indexes; several blocks on the table get a layer each in
// turn. Each is made here of the axes' coordinates and planned with the axes' limits,
// beside the job's own order, which counts the planner's ticks: it takes fewer, so the
// product has no order by sweeps. polar_tracks_test.cc has points on the tracks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include "tests/services/job/machine/polar_ticks.h"

namespace intaglio {
namespace {

using namespace polar_ticks;  // NOLINT

constexpr double kDistanceMm = 0.5;
enum Sweep { kArm = 0, kTable = 1 };  // the index of the axis that sweeps

/// Contours of a sphere, as sections give them.
PointList Sphere(const Vec3& middle_mm, double radius_mm) {
  PointList points_mm;
  for (double z = 0.5 * kDistanceMm - radius_mm; z < radius_mm; z += kDistanceMm) {
    const double r = std::sqrt(radius_mm * radius_mm - z * z);
    const int count =
        std::max(3, static_cast<int>(2 * std::numbers::pi * r / kDistanceMm));
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      points_mm.push_back(middle_mm + Vec3(r * std::cos(angle), r * std::sin(angle), z));
    }
  }
  return points_mm;
}

/// A full volume of layers with places at random, no two of a layer in one cell.
PointList Volume(const Vec3& middle_mm, double side_mm) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0.25, 0.75);
  PointList points_mm;
  const int count = static_cast<int>(side_mm / (2 * kDistanceMm));
  for (int k = 0; k < count; ++k) {
    for (int j = 0; j < count; ++j) {
      for (int i = 0; i < count; ++i) {
        const Vec3 cell(i + share(random), j + share(random), k);
        points_mm.push_back(middle_mm + 2 * kDistanceMm * cell -
                            Vec3::Constant(0.5 * side_mm));
      }
    }
  }
  return points_mm;
}

/// Layer by layer from below; in a layer the other axis indexes by `row_mm` at the
/// block, and `sweep` goes to and fro.
PointList Sweeps(const FrozenJob& job, const PointList& points_mm, Sweep sweep,
                 double row_mm) {
  const PointList axes = AxesOf(job, points_mm);
  // The arm is 150 mm long, the block about 115 mm from the table's axis.
  const double row_rad = row_mm / (sweep == kArm ? 115.0 : 150.0);
  std::vector<std::tuple<long, long, double, std::size_t>> keys;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const long layer = std::lround(points_mm[i].z() / kDistanceMm);
    const long row = std::lround(axes[i][1 - sweep] / row_rad);
    const bool is_back = (row + layer) % 2 != 0;
    keys.emplace_back(layer, row, is_back ? -axes[i][sweep] : axes[i][sweep], i);
  }
  std::ranges::sort(keys);
  std::vector<std::size_t> order;
  for (const auto& key : keys) order.push_back(std::get<3>(key));
  return InOrder(points_mm, order);
}

/// The fewest, over rows of half a distance to four.
std::uint64_t TicksOfSweeps(const FrozenJob& job, const PointList& points_mm,
                            Sweep sweep) {
  std::uint64_t fewest = UINT64_MAX;
  for (const double rows : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0}) {
    const PointList path_mm = Sweeps(job, points_mm, sweep, rows * kDistanceMm);
    fewest = std::min(fewest, TicksOf(job, AxesOf(job, path_mm)));
  }
  return fewest;
}

TEST(PolarOrder, ByTicksTakesFewerTicksThanSweepsOfTheArmOrTheTable) {
  const FrozenJob job = PolarJob();
  const struct {
    const char* name;
    PointList points_mm;
    double max_ratio;  // of the ticks of the better of both sweeps
  } clouds[] = {{"sphere", Sphere(Vec3(25, 25, 15), 12), 0.9},
                {"volume", Volume(Vec3(25, 25, 15), 16), 0.9}};
  for (const auto& [name, points_mm, max_ratio] : clouds) {
    const std::uint64_t own = TicksOf(job, AxesOf(job, JobsOwn(job, points_mm)));
    const std::uint64_t arm = TicksOfSweeps(job, points_mm, kArm);
    const std::uint64_t table = TicksOfSweeps(job, points_mm, kTable);
    RecordProperty(name,
                   testing::PrintToString(std::tuple(points_mm.size(), own, arm, table)));
    std::printf("%s: %zu points, own order %lu ticks, arm sweeps %lu, table turns %lu\n",
                name, points_mm.size(), own, arm, table);
    EXPECT_LT(static_cast<double>(own),
              max_ratio * static_cast<double>(std::min(arm, table)))
        << name;
  }
}

// Four blocks a quarter of a turn of the table apart: whole ones after each other have
// three changes, a layer in each in turn has three for each layer.
TEST(PolarOrder, WholeBlocksTakeFewerTicksThanALayerInEachInTurn) {
  const FrozenJob job = PolarJob();
  const PointList path_mm = Sweeps(job, Sphere(Vec3(25, 25, 15), 6), kTable, 1);
  const PointList axes = AxesOf(job, path_mm);
  PointList whole, in_turn;
  const auto add = [&](PointList& to, std::size_t i, int block) {
    to.push_back(axes[i] + Vec3(0, block * std::numbers::pi / 2, 0));
  };
  for (int block = 0; block < 4; ++block) {
    for (std::size_t i = 0; i < axes.size(); ++i) add(whole, i, block);
  }
  for (std::size_t first = 0, next = 0, layer = 0; first < axes.size(); first = next) {
    while (next < axes.size() && std::lround(path_mm[next].z() / kDistanceMm) ==
                                     std::lround(path_mm[first].z() / kDistanceMm)) {
      ++next;
    }
    // Back and forth, so that the table never turns all the way back.
    for (int block = 0; block < 4; ++block) {
      for (std::size_t i = first; i < next; ++i)
        add(in_turn, i, layer % 2 == 0 ? block : 3 - block);
    }
    ++layer;
  }
  ASSERT_EQ(whole.size(), in_turn.size());
  const std::uint64_t of_whole = TicksOf(job, whole), of_layers = TicksOf(job, in_turn);
  std::printf("%zu points: whole blocks %lu ticks, a layer in each in turn %lu\n",
              whole.size(), of_whole, of_layers);
  EXPECT_LT(static_cast<double>(of_whole), 0.8 * static_cast<double>(of_layers));
}

}  // namespace
}  // namespace intaglio
