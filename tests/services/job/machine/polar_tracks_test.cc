// Points that are chosen on the tracks of an arm or of a rotary table (Trochimczuk 2008
// ch. 8.3): in scenario 1 the arm sweeps at constant speed, a point in each tick, and the
// table indexes; in scenario 2 the table turns and the arm indexes. A filled cube of such
// points is compared with the lattice of the method solid, in the job's own order and in
// straight rows. In ticks per point, of 18 distances each way:
//
// clang-format off
//   distance, mm                                          0.15   0.3    0.5
//   tracks of the arm                                     1.08   1.14   1.26
//   tracks of the table                                   1.12   1.50   2.16
//   lattice, straight rows along y                        1.06   1.16   1.25
//   lattice of as many points as on the tracks of the arm,
//   the job's own order                                   1.27   1.66   2.27
//   lattice at the distance, the job's own order          1.24   1.62   1.86
// clang-format on
//
// So ticks are saved by whole rows in the direction in which both axes go fast; that they
// are tracks of one axis saves none, and at the same distance the arm's hold a fifth
// fewer points: only on one side of the block they lie as near as allowed.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <vector>

#include "engrave/sort/shadow.h"
#include "services/job/convert/rows.h"
#include "services/job/plan/point_order.h"
#include "tests/services/job/machine/polar_ticks.h"

namespace intaglio {
namespace {

using std::numbers::pi;

const Vec3 kMiddleMm(25, 25, 15);
const Vec2 kCornerMm(-25, 90);  // of the block, from the table's axis
constexpr double kArmMm = 150, kAxesMm = 200;

/// Layers of rows; each is passed to and fro.
class Rows {
 public:
  explicit Rows(double side_mm) : half_mm_(0.5 * side_mm) {}

  void Add(const Vec3& glass_mm) {
    if ((glass_mm - kMiddleMm).cwiseAbs().maxCoeff() <= half_mm_)
      row_.push_back(glass_mm);
  }
  void EndRow() {
    if (!row_.empty()) layer_.push_back(std::move(row_));
    row_.clear();
  }
  void EndLayer() {
    if (layers_++ % 2 != 0) std::ranges::reverse(layer_);
    for (PointList& row : layer_) {
      if (rows_++ % 2 != 0) std::ranges::reverse(row);
      points_mm_.insert(points_mm_.end(), row.begin(), row.end());
    }
    layer_.clear();
  }
  const PointList& points_mm() const { return points_mm_; }

 private:
  double half_mm_;
  PointList row_, points_mm_;
  std::vector<PointList> layer_;
  int layers_ = 0, rows_ = 0;
};

Vec3 GlassFrom(const Vec2& from_table_mm, double z_mm) {
  return {from_table_mm.x() - kCornerMm.x(), from_table_mm.y() - kCornerMm.y(), z_mm};
}

/// The lattice of solid.h, its rows turned counterclockwise from x.
PointList Lattice(double distance_mm, double side_mm, double turn_rad) {
  Rows rows(side_mm);
  const int n = static_cast<int>(2 * side_mm / distance_mm) + 4;
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  for (int k = -n; k <= n; ++k) {
    const int third = (k % 3 + 3) % 3;
    for (int j = -n; j <= n; ++j) {
      for (int i = -n; i <= n; ++i) {
        const double x = i + 0.5 * (j & 1) + 0.5 * third;
        const double y = std::sqrt(0.75) * j + third * 0.5 / std::numbers::sqrt3;
        rows.Add(kMiddleMm + distance_mm * Vec3(c * x - s * y, s * x + c * y,
                                                std::sqrt(2.0 / 3) * k));
      }
      rows.EndRow();
    }
    rows.EndLayer();
  }
  return rows.points_mm();
}

/// Scenario 1: equal turns of the arm that are a distance at its end; the table indexes
/// so far that its nearest tracks are a distance apart.
PointList TracksOfArm(const FrozenJob& job, double distance_mm, double side_mm) {
  Rows rows(side_mm);
  const Vec3 middle = polar_ticks::AxesOf(job, {kMiddleMm}).front();
  const double nearest_mm = kCornerMm.y() + kMiddleMm.y() - 0.5 * side_mm;
  // Tracks are r1 d sin(theta1) / r1 times the turn of the table apart.
  const double cos_arm = (kArmMm * kArmMm + kAxesMm * kAxesMm - nearest_mm * nearest_mm) /
                         (2 * kArmMm * kAxesMm);
  const double index_rad = distance_mm / (kAxesMm * std::sqrt(1 - cos_arm * cos_arm));
  const int n = static_cast<int>(2 * side_mm / distance_mm) + 4;
  for (int k = -n; k <= n; ++k) {
    for (int j = -n; j <= n; ++j) {
      for (int i = -n; i <= n; ++i) {
        const double arm = middle.x() + i * distance_mm / kArmMm;
        const double table = middle.y() + index_rad * (j + 0.5 * (k & 1));
        const Vec2 beam(kArmMm * std::sin(arm), kAxesMm - kArmMm * std::cos(arm));
        rows.Add(GlassFrom(Eigen::Rotation2Dd(-table) * beam,
                           kMiddleMm.z() + std::sqrt(0.75) * distance_mm * k));
      }
      rows.EndRow();
    }
    rows.EndLayer();
  }
  return rows.points_mm();
}

/// Scenario 2: the lattice bent about the table's axis, with equal turns of the table
/// that are a distance on the nearest track.
PointList TracksOfTable(double distance_mm, double side_mm) {
  Rows rows(side_mm);
  const double nearest_mm = kCornerMm.y() + kMiddleMm.y() - 0.5 * side_mm;
  const int n = static_cast<int>(2 * side_mm / distance_mm) + 4;
  for (int k = -n; k <= n; ++k) {
    const int third = (k % 3 + 3) % 3;
    for (int j = -1; j <= n; ++j) {
      const double r_mm = nearest_mm + distance_mm * (std::sqrt(0.75) * j +
                                                      third * 0.5 / std::numbers::sqrt3);
      for (int i = -n; i <= n; ++i) {
        const double beta = distance_mm / nearest_mm * (i + 0.5 * (j & 1) + 0.5 * third);
        rows.Add(GlassFrom(r_mm * Vec2(std::sin(beta), std::cos(beta)),
                           kMiddleMm.z() + std::sqrt(2.0 / 3) * distance_mm * k));
      }
      rows.EndRow();
    }
    rows.EndLayer();
  }
  return rows.points_mm();
}

double MinDistance(PointList points_mm) {
  std::ranges::sort(points_mm, {}, [](const Vec3& p) { return p.x(); });
  double min_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    for (std::size_t k = i + 1;
         k < points_mm.size() && points_mm[k].x() - points_mm[i].x() < min_mm; ++k) {
      min_mm = std::min(min_mm, (points_mm[k] - points_mm[i]).norm());
    }
  }
  return min_mm;
}

double TicksPerPoint(const FrozenJob& job, const PointList& points_mm) {
  return static_cast<double>(
             polar_ticks::TicksOf(job, polar_ticks::AxesOf(job, points_mm))) /
         static_cast<double>(points_mm.size());
}

TEST(PolarTracks, TakeFewerTicksThanTheLatticeInItsOwnOrderAndNoFewerThanItsRows) {
  const FrozenJob job = polar_ticks::PolarJob();
  for (const double distance_mm : {0.15, 0.3, 0.5}) {
    const double side_mm = 18 * distance_mm;
    const PointList arm_mm = TracksOfArm(job, distance_mm, side_mm);
    const PointList table_mm = TracksOfTable(distance_mm, side_mm);
    const PointList rows_mm = Lattice(distance_mm, side_mm, pi / 2);
    // As many points as on the arm's tracks, farther apart.
    const double share =
        static_cast<double>(rows_mm.size()) / static_cast<double>(arm_mm.size());
    const PointList as_many_mm = Lattice(distance_mm * std::cbrt(share), side_mm, 0);
    for (const PointList* cloud : {&arm_mm, &table_mm, &rows_mm, &as_many_mm})
      EXPECT_GE(MinDistance(*cloud), 0.999 * distance_mm);
    const double arm = TicksPerPoint(job, arm_mm), table = TicksPerPoint(job, table_mm),
                 rows = TicksPerPoint(job, rows_mm),
                 own = TicksPerPoint(job, polar_ticks::JobsOwn(job, as_many_mm)),
                 own_of_rows = TicksPerPoint(
                     job, polar_ticks::JobsOwn(job, Lattice(distance_mm, side_mm, 0)));
    std::printf(
        "%g mm, ticks per point: arm %.3f (%zu), table %.3f (%zu), rows %.3f "
        "(%zu), own order %.3f (%zu), at the same distance %.3f\n",
        distance_mm, arm, arm_mm.size(), table, table_mm.size(), rows, rows_mm.size(),
        own, as_many_mm.size(), own_of_rows);
    EXPECT_LT(arm, 0.9 * own) << distance_mm;
    EXPECT_LT(rows, 0.9 * own_of_rows) << distance_mm;
    EXPECT_LT(std::abs(rows - arm), 0.05 * arm) << distance_mm;
    EXPECT_GT(rows_mm.size(), 1.2 * static_cast<double>(arm_mm.size())) << distance_mm;
    EXPECT_GT(table, rows) << distance_mm;
  }
}

/// A job that fills a model with the lattice, in rows.
FrozenJob RowsJob(double distance_mm) {
  FrozenJob job = polar_ticks::PolarJob();
  JobSpec spec = job.job();
  spec.mutable_discretization()->set_min_spacing_mm(distance_mm);
  spec.mutable_models(0)->mutable_solid()->set_distance_mm(distance_mm);
  spec.mutable_ordering()->mutable_boustrophedon();
  *job.mutable_job() = WithDefaults(spec, job.machine());
  return job;
}

// As the product makes both: the lattice of the method solid as it lies, with rows along
// x, 60 and 120 degrees from it, in rows in the direction that is chosen for the machine
// and in the order by ticks.
TEST(PolarTracks, RowsInTheChosenDirectionTakeFewerTicksThanOthersAndTheOrderByTicks) {
  const FrozenJob by_ticks = polar_ticks::PolarJob();
  for (const double distance_mm : {0.15, 0.3, 0.5}) {
    const FrozenJob job = RowsJob(distance_mm);
    const PointList cloud_mm = Lattice(distance_mm, 18 * distance_mm, 0);
    const auto ticks = [&](const FrozenJob& in) {
      return TicksPerPoint(by_ticks, polar_ticks::JobsOwn(in, cloud_mm));
    };
    const double chosen = ticks(job), own = ticks(by_ticks);
    std::printf("%g mm, ticks per point: rows %.3f, own order %.3f\n", distance_mm,
                chosen, own);
    EXPECT_LT(chosen, 0.95 * own) << distance_mm;
    for (const double turn_deg : {0.0, 60.0, 90.0, 120.0}) {
      FrozenJob other = job;
      other.mutable_job()->mutable_ordering()->mutable_boustrophedon()->set_row_turn_deg(
          turn_deg);
      // Where every direction is fast enough, at 0.15 mm, rows askew to the cube have
      // more ends: 1.15 ticks a point in place of 1.11.
      EXPECT_LE(chosen, (distance_mm < 0.2 ? 1.04 : 1) * ticks(other))
          << distance_mm << " " << turn_deg;
      std::printf("  rows at %g deg %.3f\n", turn_deg, ticks(other));
    }
  }
}

/// In the cube -1..1.
struct Shape {
  const char* name;
  bool (*has)(const Vec3& p);
};
const Shape kShapes[] = {
    {"cube", [](const Vec3&) { return true; }},
    {"dented sphere",
     [](const Vec3& p) {
       const Vec3 u = p.normalized();
       return p.norm() <
              0.8 * (1 + 0.2 * std::sin(5 * u.x()) * std::cos(4 * u.y() + 3 * u.z()));
     }},
    {"ring",
     [](const Vec3& p) { return std::hypot(p.head<2>().norm() - 0.7, p.z()) < 0.3; }}};

PointList Filled(const Shape& shape, double distance_mm, double side_mm) {
  PointList points_mm;
  for (const Vec3& p : Lattice(distance_mm, side_mm, 0)) {
    if (shape.has((p - kMiddleMm) / (0.5 * side_mm))) points_mm.push_back(p);
  }
  return points_mm;
}

// Whether rows take fewer ticks than the order by ticks depends on rate and distance: a
// job plans both (point_order.h). INTAGLIO_LONG=1 prints the table of
// docs/measurements.md.
TEST(PolarTracks, RowsTakeFewerTicksThanTheOrderByTicksAtHighRatesAlone) {
  const bool is_long = std::getenv("INTAGLIO_LONG") != nullptr;
  const std::vector<double> distances_mm =
      is_long ? std::vector{0.15, 0.3, 0.5} : std::vector{0.3};
  const std::vector<double> rates_hz =
      is_long ? std::vector{25.0, 50.0, 100.0, 200.0} : std::vector{100.0, 200.0};
  for (const Shape& shape : kShapes) {
    for (const double distance_mm : distances_mm) {
      FrozenJob by_ticks = polar_ticks::PolarJob(), in_rows = RowsJob(distance_mm);
      const PointList cloud_mm = Filled(shape, distance_mm, 18 * distance_mm);
      for (const double rate_hz : rates_hz) {
        for (FrozenJob* job : {&by_ticks, &in_rows})
          job->mutable_job()->mutable_laser()->set_rate_hz(rate_hz);
        const PointList rows_mm = polar_ticks::JobsOwn(in_rows, cloud_mm);
        const double rows = TicksPerPoint(in_rows, rows_mm),
                     own = TicksPerPoint(by_ticks,
                                         polar_ticks::JobsOwn(by_ticks, cloud_mm));
        std::printf("%s, %g mm, %g Hz, %zu points: own order %.3f, rows %.3f\n",
                    shape.name, distance_mm, rate_hz, cloud_mm.size(), own, rows);
        EXPECT_EQ(sort::CountShadowViolations(rows_mm, OrderOptionsOf(in_rows).cone), 0);
        if (distance_mm != 0.3) continue;
        if (rate_hz == 200) {
          EXPECT_LT(rows, 0.9 * own) << shape.name;
        } else if (rate_hz == 100) {
          EXPECT_GT(rows, 1.02 * own) << shape.name;
        }
      }
    }
  }
}

/// A job with the machine of this file that fills a model with the lattice of 0.3 mm, in
/// the order that it has by default.
FrozenJob SolidJob(const char* machine, double rate_hz) {
  FrozenJob job = RowsJob(0.3);
  *job.mutable_machine() =
      ReadMachineFile(std::string(INTAGLIO_SOURCE_DIR "/deploy/machines/") + machine)
          .value();
  JobSpec spec = job.job();
  spec.clear_ordering();
  spec.mutable_laser()->set_rate_hz(rate_hz);
  *job.mutable_job() = WithDefaults(spec, job.machine());
  return job;
}

// An order by ticks begins with the rows of a lattice where they take fewer ticks than a
// greedy order.
TEST(PolarTracks, AJobOfOneLatticeTakesFewerTicksThanRowsAndThanAGreedyStartAnnealed) {
  for (const char* machine : {"polar.textproto", "els-03.textproto"}) {
    for (const Shape& shape : kShapes) {
      const PointList cloud_mm = Filled(shape, 0.3, 18 * 0.3);
      for (const double rate_hz : {100.0, 200.0}) {
        const FrozenJob job = SolidJob(machine, rate_hz);
        const std::vector<ChannelMask> masks(cloud_mm.size(), 1);
        const auto ticks = [&](const PointList& path_mm) {
          return TicksPerPoint(job, path_mm);
        };
        const PointList own_mm = polar_ticks::InOrder(
            cloud_mm, OrderPoints(job, cloud_mm, masks, OrderOptionsOf(job), {}).value());
        FrozenJob in_rows = job;
        FillRows(*in_rows.mutable_job()->mutable_ordering()->mutable_boustrophedon(),
                 job.job());
        const double own = ticks(own_mm),
                     rows = ticks(polar_ticks::JobsOwn(in_rows, cloud_mm)),
                     greedy = ticks(polar_ticks::JobsOwn(job, cloud_mm));
        std::printf(
            "%s, %s, %g Hz: own order %.3f, rows %.3f, greedy start annealed %.3f\n",
            machine, shape.name, rate_hz, own, rows, greedy);
        EXPECT_LE(own, 1.002 * std::min(rows, greedy))
            << machine << shape.name << rate_hz;
        EXPECT_EQ(sort::CountShadowViolations(own_mm, OrderOptionsOf(job).cone), 0);
      }
    }
  }
}

// Four blocks a quarter of a turn apart, and a table that turns on in one direction,
// without an end of its travel: a layer in each in turn needs a quarter of a turn for
// each layer of each block, 4 where a table that turns to and fro needs 3. With a track
// in each instead, as in scenario 2, the table makes a turn for each track.
TEST(PolarTracks, WholeBlocksTakeFewerTicksThanALayerInEachOnATableThatTurnsOn) {
  FrozenJob job = polar_ticks::PolarJob();
  RotaryAxis& table = *job.mutable_machine()->mutable_polar()->mutable_table();
  table.set_travel_max_rad(2000);
  constexpr double kDistance = 0.15;
  const PointList path_mm = TracksOfTable(kDistance, 12 * kDistance);
  const PointList axes = polar_ticks::AxesOf(job, path_mm);
  const auto in_blocks = [&](const auto& ends) {
    PointList all;
    double turn = 0;
    for (std::size_t first = 0, next = 0; first < axes.size(); first = next) {
      do {
        ++next;
      } while (next < axes.size() && !ends(next));
      for (int block = 0; block < 4; ++block, turn += pi / 2) {
        for (std::size_t i = first; i < next; ++i)
          all.push_back(axes[i] + Vec3(0, turn, 0));
      }
    }
    return all;
  };
  const auto at_layers = [&](std::size_t i) {
    return path_mm[i].z() > path_mm[i - 1].z() + 0.01;
  };
  const auto at_tracks = [&](std::size_t i) {
    return at_layers(i) || std::abs(axes[i].x() - axes[i - 1].x()) > 1e-6;
  };
  const auto ticks = [&](const PointList& all) {
    return static_cast<double>(polar_ticks::TicksOf(job, all));
  };
  const PointList whole = in_blocks([](std::size_t) { return false; });
  const PointList layers = in_blocks(at_layers), tracks = in_blocks(at_tracks);
  ASSERT_EQ(whole.size(), layers.size());
  ASSERT_EQ(whole.size(), tracks.size());
  const double of_whole = ticks(whole), of_layers = ticks(layers),
               of_tracks = ticks(tracks);
  // Any acceleration at all: what is left of the turns is the table's speed.
  table.set_max_acceleration_rad_s2(1e5);
  const double free_whole = ticks(whole), free_layers = ticks(layers);
  std::printf(
      "%zu points in four blocks: whole blocks %.0f ticks, a layer in each in "
      "turn %.0f, a track in each in turn %.0f; a table without inertia: %.0f "
      "and %.0f\n",
      whole.size(), of_whole, of_layers, of_tracks, free_whole, free_layers);
  EXPECT_LT(of_whole, 0.8 * of_layers);
  EXPECT_LT(free_whole, 0.8 * free_layers);
  EXPECT_LT(of_layers, 0.3 * of_tracks);
}

}  // namespace
}  // namespace intaglio
