// Discretization beside other programs and libraries, in one run, as a table:
//   discretize_bench [MODEL]
// Without a model: $INTAGLIO_MESH, else a knot of 70 000 triangles. It is turned upright
// (y becomes z) and its largest extent made 60 mm; layers and spacing are 0.1 mm. Times
// are the best of a few runs on one thread, with all the work of a job each time:
// neighbourhood of the triangles, trees, memory not used before. Below sections and
// thinning stands what their input and their points alone take to be read and written
// once, at the speed at which this computer copies memory in the same run: no method can
// be faster.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/spacing/thinning.h"
#include "engrave/mesh/import/mesh_import.h"
#include "engrave/mesh/placement.h"
#include "engrave/proof/nearest_distances.h"
#include "tests/bench/discretize_peers.h"
#include "tests/engrave/mesh/mesh_file.h"

namespace intaglio::bench {
namespace {

using namespace discretize;

constexpr double kSpacingMm = 0.1;
constexpr int kRuns = 9;
constexpr std::size_t kRandomPoints = 7'600'000;
const Vec3 kBlockMm(100, 100, 100);

/// A tube along a (2, 3) torus knot.
mesh::TriangleMesh Knot() {
  constexpr std::uint32_t kAlong = 700, kAround = 50;
  const auto place = [](double t) {
    const double r = 2 + std::cos(3 * t);
    return Vec3(r * std::cos(2 * t), std::sin(3 * t), r * std::sin(2 * t));
  };
  mesh::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kAlong; ++i) {
    const double t = 2 * std::numbers::pi * i / kAlong;
    const Vec3 along = (place(t + 1e-4) - place(t - 1e-4)).normalized();
    const Vec3 u = along.unitOrthogonal(), v = along.cross(u);
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double turn = 2 * std::numbers::pi * j / kAround;
      mesh.vertices.push_back(place(t) + 0.4 * (std::cos(turn) * u + std::sin(turn) * v));
      const std::uint32_t a = i * kAround + j, b = i * kAround + (j + 1) % kAround;
      const std::uint32_t next = kAlong * kAround;
      const std::uint32_t c = (a + kAround) % next, d = (b + kAround) % next;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  }
  return mesh;
}

std::optional<mesh::TriangleMesh> Model(const char* file) {
  mesh::TriangleMesh model;
  if (file == nullptr) {
    model = Knot();
  } else {
    auto imported = mesh::ImportMesh(file);
    if (!imported) {
      fmt::print(stderr, "{}\n", imported.error().message);
      return std::nullopt;
    }
    model = *std::move(imported);
  }
  mesh::Placement placement;
  placement.rotation_rad.x() = std::numbers::pi / 2;
  placement.fit = mesh::FitLargest{60};
  auto placed = mesh::PlaceInBlock(model, placement, kBlockMm);
  if (!placed) {
    fmt::print(stderr, "{}\n", placed.error().message);
    return std::nullopt;
  }
  return *std::move(placed);
}

void Line(const std::string& work, const std::string& result, double our_ms,
          const char* peer, const std::optional<PeerRun>& run) {
  if (!run) {
    fmt::print("| {} | {} | {:.1f} ms | {}: not installed | |\n", work, result, our_ms,
               peer);
    return;
  }
  const std::string count =
      run->count > 0 ? fmt::format(" ({:.0f})", run->count) : std::string();
  fmt::print("| {} | {} | {:.1f} ms | {}{} {:.0f} ms | {:.1f} |\n", work, result, our_ms,
             peer, count, run->ms, run->ms / our_ms);
}

/// Bytes read and written a second, by a copy that no cache holds.
double CopiedBytesPerMs() {
  static const double speed = [] {
    const std::vector<std::uint64_t> from(32'000'000, 1);
    std::vector<std::uint64_t> to(from.size());
    const double ms = BestMs(kRuns, [&] { std::ranges::copy(from, to.begin()); });
    return 2.0 * static_cast<double>(from.size() * sizeof from[0]) / ms;
  }();
  return speed;
}

/// `bytes`: of what is read, and of what is written.
void Bound(double bytes, double our_ms) {
  const double bound_ms = bytes / CopiedBytesPerMs();
  fmt::print("| bound: {:.1f} MB at {:.1f} GB/s | | {:.1f} ms | | {:.1f} |\n",
             bytes / 1e6, CopiedBytesPerMs() / 1e6, bound_ms, our_ms / bound_ms);
}

/// Place, source and spacing of a point.
double BytesOf(std::size_t point_count) {
  return static_cast<double>(point_count * (sizeof(Vec3) + 4 + 4));
}

double BytesOf(const mesh::TriangleMesh& mesh) {
  return static_cast<double>(mesh.vertices.size() * sizeof(Vec3) +
                             mesh.triangles.size() * sizeof(mesh.triangles[0]));
}

/// The range of all the heights in equal slabs, on so many threads; ms.
double SlabsMs(const PointSource& source, unsigned workers) {
  constexpr int kSlabs = 16;
  const Box3 box = source.Bounds();
  const auto height = [&](int slab) {
    return box.min_mm.z() + box.size_mm().z() * slab / kSlabs - (slab == 0 ? 1 : 0) +
           (slab == kSlabs ? 1 : 0);
  };
  return BestMs(kRuns, [&] {
    std::mutex mutex;
    int next = 0;
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < workers; ++i) {
      threads.emplace_back([&] {
        SpacedCloud cloud;
        for (;;) {
          std::unique_lock lock(mutex);
          const int slab = next++;
          lock.unlock();
          if (slab >= kSlabs) return;
          cloud.Resize(0);
          source.AddPoints({height(slab), height(slab + 1)}, 0, {}, cloud).value();
        }
      });
    }
  });
}

void Slicing(const mesh::TriangleMesh& mesh) {
  SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = kSpacingMm;
  MethodStatistics statistics;
  const double points_ms = BestMs(kRuns, [&] {
    SpacedCloud cloud;
    statistics = MakeSections(mesh, options).value()->AddPoints({}, 0, {}, cloud).value();
  });
  // Points farther apart than any contour is long are one a contour: the slices alone.
  options.vertex_distance_mm = 1e6;
  options.parallel_faces = ParallelFaces::kReport;
  const double slices_ms = BestMs(kRuns, [&] {
    SpacedCloud cloud;
    MakeSections(mesh, options).value()->AddPoints({}, 0, {}, cloud).value();
  });
  const auto contours = statistics.closed_contour_count + statistics.open_contour_count;
  const std::string slices =
      fmt::format("{} planes, {} contours", statistics.plane_count, contours);
  const auto cura = CuraSlices(mesh, kSpacingMm);
  const auto cgal = CgalSlices(mesh, mesh.Bounds().min_mm.z() + 0.1 * kSpacingMm,
                               kSpacingMm, statistics.plane_count);
  Line("contours", slices, slices_ms, "CuraEngine", cura);
  Line("contours", slices, slices_ms, "CGAL slicer", cgal);
  const std::string points = fmt::format("{} points", statistics.point_count);
  Line("contours and points", points, points_ms, "CuraEngine, no points", cura);
  Line("contours and points", points, points_ms, "CGAL slicer, no points", cgal);
  Bound(BytesOf(mesh) + BytesOf(statistics.point_count), points_ms);
  options.vertex_distance_mm = kSpacingMm;
  const auto source = MakeSections(mesh, options).value();
  const double one_ms = SlabsMs(*source, 1), two_ms = SlabsMs(*source, 2);
  fmt::print(
      "| points in 16 slabs, 1 and 2 workers | {} | {:.1f}, {:.1f} ms | | {:.2f} |\n",
      points, one_ms, two_ms, one_ms / two_ms);
}

void Rays(const mesh::TriangleMesh& mesh) {
  RayOptions options;
  options.distance_mm = kSpacingMm;
  options.direction = {Axis::kZ, Vec3(0.3, 0.2, 0)};
  MethodStatistics statistics;
  const double our_ms = BestMs(kRuns, [&] {
    SpacedCloud cloud;
    statistics = MakeRays(mesh, options).value()->AddPoints({}, 0, {}, cloud).value();
  });
  const Mat3 frame = FrameOf(options.direction);
  Box3 box;
  for (const Vec3& v : mesh.vertices) box.Extend(frame.transpose() * v);
  RayBundle bundle;
  bundle.origin_mm = frame * (box.min_mm - Vec3(0, 0, 1));
  bundle.across_u_mm = frame.col(0) * kSpacingMm;
  bundle.across_v_mm = frame.col(1) * kSpacingMm;
  bundle.direction = frame.col(2);
  bundle.columns = static_cast<int>(box.size_mm().x() / kSpacingMm) + 1;
  bundle.rows = static_cast<int>(box.size_mm().y() / kSpacingMm) + 1;
  Line("oblique rays, every crossing",
       fmt::format("{} rays of {} met, {} crossings, {} odd", statistics.ray_count,
                   bundle.columns * bundle.rows, statistics.point_count,
                   statistics.odd_ray_count),
       our_ms, "Embree, tree and rays", EmbreeRays(mesh, bundle));
  const auto source = MakeRays(mesh, options).value();
  const double one_ms = SlabsMs(*source, 1), two_ms = SlabsMs(*source, 2);
  fmt::print(
      "| the same in 16 slabs, 1 and 2 workers | | {:.1f}, {:.1f} ms | | {:.2f} |\n",
      one_ms, two_ms, one_ms / two_ms);
}

/// Anywhere on the surface, as likely here as there.
SpacedCloud RandomPoints(const mesh::TriangleMesh& mesh, std::size_t count) {
  std::vector<double> area_below;
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    area_below.push_back(area += (q - p).cross(r - p).norm() / 2);
  }
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  SpacedCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at =
        std::upper_bound(area_below.begin(), area_below.end() - 1, area * share(random)) -
        area_below.begin();
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(at)];
    const double u = std::sqrt(share(random)), v = share(random);
    cloud.Add((1 - u) * mesh.vertices[a] + u * (1 - v) * mesh.vertices[b] +
                  u * v * mesh.vertices[c],
              0);
  }
  return cloud;
}

void Thinning(const std::string& work, const SpacedCloud& candidates) {
  ThinningOptions thinning;
  thinning.min_spacing_mm = kSpacingMm;
  SpacedCloud kept;
  const double our_ms = BestMs(5, [&] { kept = Thin(candidates, thinning); });
  const proof::DistinctPlaces places = proof::DistinctPlacesOf(kept.points_mm);
  const auto nearest =
      proof::MeasureNearest(places, proof::PointTree(places.places_mm), {kSpacingMm});
  Line(work,
       fmt::format("{} of {} points, nearest distances vary by {:.1f} %", kept.size(),
                   candidates.size(), 100 * nearest.variation_ratio),
       our_ms, "CloudCompare spatial",
       CloudCompareThinning(candidates.points_mm, kSpacingMm));
  Bound(BytesOf(candidates.size()) + BytesOf(kept.size()), our_ms);
}

void Thinning(const mesh::TriangleMesh& mesh) {
  SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = kSpacingMm / 2;
  SpacedCloud rows;
  MakeSections(mesh, options).value()->AddPoints({}, 0, {}, rows).value();
  Thinning("thinning of sections twice as dense", rows);
  Thinning("thinning of random points", RandomPoints(mesh, kRandomPoints));
}

double LoadAverage() {
  double minute = 0;
  return getloadavg(&minute, 1) == 1 ? minute : 0;
}

int Main(int argc, char** argv) {
  const auto mesh = Model(argc > 1 ? argv[1] : std::getenv("INTAGLIO_MESH"));
  if (!mesh) return 1;
  fmt::print("{} triangles; load {:.1f}\n\n", mesh->triangles.size(), LoadAverage());
  fmt::print("| work | result | time | peer | ratio |\n|---|---|---|---|---|\n");
  Slicing(*mesh);
  Rays(*mesh);
  Thinning(*mesh);
  return 0;
}

}  // namespace
}  // namespace intaglio::bench

int main(int argc, char** argv) { return intaglio::bench::Main(argc, argv); }
