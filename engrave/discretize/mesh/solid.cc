#include "engrave/discretize/mesh/solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/mesh/solid_lattice.h"
#include "engrave/discretize/mesh/surface_lattice.h"
#include "engrave/discretize/spacing/candidate_limit.h"

// Every third layer of the lattice lies directly above the first: layer m is the
// triangular lattice moved by (m mod 3) (1/2, 1/sqrt(12)) distances, sqrt(2/3) distances
// above layer m - 1. So each vertical line through nodes belongs to one of three
// lattices, and the surface is projected onto each of them.

namespace intaglio::discretize {
namespace {

constexpr std::uint64_t kTrianglesBetweenReports = 8192;

struct Crossing {
  std::int64_t i, j;
  double x_mm, y_mm, z_mm;

  bool SameLine(const Crossing& other) const { return i == other.i && j == other.j; }
};

struct Line {
  double x_mm, y_mm;
  std::size_t begin;  ///< of its crossings
};

/// The lines of one of the three lattices that meet the surface.
struct Lines {
  std::vector<Line> lines;  ///< and one more, for the end of the last
  std::vector<double> z_mm;
};

class SolidSource final : public PointSource {
 public:
  SolidSource(const SolidOptions& options, const Box3& bounds,
              std::array<Lines, 3> lattices)
      : spacing_mm_(UpwardSingle(options.distance_mm)),
        layer_mm_(SolidLayerRatio() * options.height_ratio * spacing_mm_ *
                  kRoundingAllowance),
        bounds_(bounds),
        lattices_(std::move(lattices)) {}

  Box3 Bounds() const override { return bounds_; }
  double MaxSpacing() const override { return spacing_mm_; }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink&,
                                     SpacedCloud& cloud) const override {
    MethodStatistics statistics;
    const std::size_t before = cloud.size();
    for (int lattice = 0; lattice < 3; ++lattice) {
      const auto& [lines, z_mm] = lattices_[lattice];
      for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
        const std::size_t begin = lines[k].begin, end = lines[k + 1].begin;
        const bool odd = (end - begin) % 2 == 1;
        if (range.Contains(z_mm[begin])) {
          ++statistics.ray_count;
          statistics.odd_ray_count += odd ? 1 : 0;
        }
        if (odd) continue;
        for (std::size_t at = begin; at < end; at += 2) {
          AddBetween(lines[k], z_mm[at], z_mm[at + 1], lattice, range, source, cloud);
        }
      }
    }
    statistics.point_count = cloud.size() - before;
    INTAGLIO_TRY(CheckCandidateCount(static_cast<double>(statistics.point_count)));
    return statistics;
  }

 private:
  void AddBetween(const Line& line, double low_mm, double high_mm, int lattice,
                  const HeightRange& range, std::uint32_t source,
                  SpacedCloud& cloud) const {
    const double from_mm = std::max(low_mm, range.low_mm);
    const double to_mm = std::min(high_mm, range.high_mm);
    if (!(from_mm < to_mm)) return;
    // One layer too low at first, whatever rounding does.
    auto layer = static_cast<std::int64_t>(std::floor(from_mm / layer_mm_)) - 1;
    while ((layer % 3 + 3) % 3 != lattice) --layer;
    for (;; layer += 3) {
      const double z_mm = static_cast<double>(layer) * layer_mm_;
      if (z_mm > to_mm) return;
      if (z_mm > low_mm && z_mm < high_mm && range.Contains(z_mm)) {
        cloud.Add(Vec3(line.x_mm, line.y_mm, z_mm), source, spacing_mm_);
      }
    }
  }

  float spacing_mm_;
  double layer_mm_;
  Box3 bounds_;
  std::array<Lines, 3> lattices_;
};

Lines LinesOf(std::vector<Crossing> crossings) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.j, a.i, a.z_mm) < std::tie(b.j, b.i, b.z_mm);
  });
  Lines lines;
  lines.z_mm.reserve(crossings.size());
  for (std::size_t k = 0; k < crossings.size(); ++k) {
    const Crossing& c = crossings[k];
    if (k == 0 || !c.SameLine(crossings[k - 1]))
      lines.lines.push_back({c.x_mm, c.y_mm, k});
    lines.z_mm.push_back(c.z_mm);
  }
  lines.lines.push_back({0, 0, crossings.size()});
  return lines;
}

/// The lines of the lattice that is moved by `shift`.
Result<Lines> CrossLattice(const mesh::TriangleMesh& mesh, const Vec3& shift_mm,
                           double step_mm, const ProgressSink& progress) {
  std::vector<Crossing> crossings;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    if (k % kTrianglesBetweenReports == 0 && progress &&
        !progress(k, mesh.triangles.size())) {
      return Fail(ErrorCode::kCancelled, "filling a solid was cancelled");
    }
    const mesh::Triangle& t = mesh.triangles[k];
    // Every vertex is moved once, so shared edges stay shared.
    const Corners c = {mesh.vertices[t[0]] - shift_mm, mesh.vertices[t[1]] - shift_mm,
                       mesh.vertices[t[2]] - shift_mm};
    const Vec3 normal = (c[1] - c[0]).cross(c[2] - c[0]);
    const double nodes = std::abs(normal.z()) / (2 * step_mm * step_mm);
    INTAGLIO_TRY(CheckCandidateCount(static_cast<double>(crossings.size()) + nodes));
    ForEachNode(
        c, normal, LatticeFrames()[0], step_mm, {},
        [&](const Vec3& p, std::int64_t i, std::int64_t j) {
          crossings.push_back({i, j, p.x() + shift_mm.x(), p.y() + shift_mm.y(), p.z()});
        });
  }
  return LinesOf(std::move(crossings));
}

}  // namespace

Result<std::unique_ptr<PointSource>> MakeSolid(const mesh::TriangleMesh& mesh,
                                               const SolidOptions& options,
                                               const ProgressSink& progress) {
  Require(options.distance_mm > 0, "distance_mm must be positive, is {}",
          options.distance_mm);
  Require(options.height_ratio >= 1 && options.height_ratio <= 10,
          "height_ratio must be 1..10, is {}", options.height_ratio);
  const double step_mm = UpwardSingle(options.distance_mm) * kRoundingAllowance;
  std::array<Lines, 3> lattices;
  for (int k = 0; k < 3; ++k) {
    const Vec3 shift_mm = k * step_mm * Vec3(0.5, 0.5 / std::numbers::sqrt3, 0);
    auto lines = INTAGLIO_TRY(CrossLattice(mesh, shift_mm, step_mm, progress));
    lattices[static_cast<std::size_t>(k)] = std::move(lines);
  }
  return std::make_unique<SolidSource>(options, mesh.Bounds(), std::move(lattices));
}

}  // namespace intaglio::discretize
