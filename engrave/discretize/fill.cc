#include "engrave/discretize/fill.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/discretize/candidate_limit.h"

// A triangle A B C with its longest edge AB gets candidates on lines parallel to AB, a
// step apart in height and along the lines; the first and the last of a line lie on the
// other two edges. The step is half the distance, so every place of the triangle is
// nearer than step / sqrt(2) = 0.36 distances to a candidate, and after a weld to the
// distance nearer than 1.36 to a point.

namespace intaglio::discretize {
namespace {

constexpr double kStepRatio = 0.5;
constexpr std::uint64_t kTrianglesPerReport = 8192;

struct Corners {
  Vec3 a, b, c;  // ab is the longest edge
};

Corners LongestFirst(const mesh::TriangleMesh& mesh, const mesh::Triangle& triangle) {
  const Vec3 p[3] = {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                     mesh.vertices[triangle[2]]};
  int longest = 0;
  double length = -1;
  for (int i = 0; i < 3; ++i) {
    const double edge = (p[(i + 1) % 3] - p[i]).squaredNorm();
    if (edge > length) {
      length = edge;
      longest = i;
    }
  }
  return {p[longest], p[(longest + 1) % 3], p[(longest + 2) % 3]};
}

/// Points from p to q at equal steps of at most step_mm; the ends only if `ends`.
void AddLine(const Vec3& p, const Vec3& q, double step_mm, bool ends,
             std::uint32_t source, PointCloud& cloud) {
  const int parts = std::max(1, static_cast<int>(std::ceil((q - p).norm() / step_mm)));
  for (int i = ends ? 0 : 1; i <= (ends ? parts : parts - 1); ++i) {
    cloud.Add(p + (q - p) * (static_cast<double>(i) / parts), source);
  }
}

void AddTriangle(const Corners& t, double step_mm, bool full, std::uint32_t source,
                 PointCloud& cloud) {
  const double height_mm = (t.b - t.a).cross(t.c - t.a).norm() / (t.b - t.a).norm();
  const int rows = std::max(1, static_cast<int>(std::ceil(height_mm / step_mm)));
  for (int row = full ? 0 : 1; row < rows; ++row) {
    const double up = static_cast<double>(row) / rows;
    AddLine(t.a + (t.c - t.a) * up, t.b + (t.c - t.b) * up, step_mm, full, source, cloud);
  }
  if (full) cloud.Add(t.c, source);
}

}  // namespace

Result<MethodStatistics> FillTriangles(const mesh::TriangleMesh& mesh,
                                       const FillOptions& options, std::uint32_t source,
                                       const ProgressSink& progress, PointCloud& cloud) {
  Require(options.vertex_distance_mm > 0, "vertex_distance_mm must be positive, is {}",
          options.vertex_distance_mm);
  MethodStatistics statistics;
  const std::size_t before = cloud.size();
  const double step_mm = kStepRatio * options.vertex_distance_mm;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % kTrianglesPerReport == 0 && progress && !progress(i, mesh.triangles.size())) {
      return Fail(ErrorCode::kCancelled, "the fill of triangles was cancelled");
    }
    const Corners t = LongestFirst(mesh, mesh.triangles[i]);
    const double doubled_area = (t.b - t.a).cross(t.c - t.a).norm();
    if (!(doubled_area > 0)) {
      ++statistics.rejected_triangle_count;
      continue;
    }
    const double longest_mm = (t.b - t.a).norm();
    const double fitting =
        (longest_mm / step_mm + 2) * (doubled_area / longest_mm / step_mm + 2);
    const Status few = CheckCandidateCount(static_cast<double>(cloud.size()) + fitting);
    if (!few) return tl::unexpected(few.error());
    if (longest_mm < step_mm) {
      ++statistics.small_triangle_count;
      cloud.Add((t.a + t.b + t.c) / 3, source);
      continue;
    }
    AddTriangle(t, step_mm, options.full_fill, source, cloud);
    if (!options.full_fill) cloud.Add((t.a + t.b + t.c) / 3, source);
  }
  statistics.point_count = cloud.size() - before;
  return statistics;
}

}  // namespace intaglio::discretize
