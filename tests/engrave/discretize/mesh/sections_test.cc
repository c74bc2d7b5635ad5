#include "engrave/discretize/mesh/sections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/source_checks.h"

namespace intaglio::discretize {
namespace {

MethodStatistics Cut(const mesh::TriangleMesh& mesh, const SectionOptions& options,
                     SpacedCloud& cloud) {
  const auto source = MakeSections(mesh, options);
  EXPECT_TRUE(source.has_value());
  const auto statistics = (*source)->AddPoints({}, 3, {}, cloud);
  EXPECT_TRUE(statistics.has_value());
  return *statistics;
}

SectionOptions Fine(double distance_mm) {
  SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = distance_mm;
  options.parallel_faces = ParallelFaces::kReport;
  return options;
}

// Noisy, with a hole, turned faces, a fin of three triangles on an edge and a triangle
// without area: everything a file may bring.
mesh::TriangleMesh Rough() {
  auto mesh = Icosphere(4, 3, Vec3(5, 6, 7));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);
  for (Vec3& v : mesh.vertices) v += Vec3(noise(random), noise(random), noise(random));
  mesh.triangles.erase(mesh.triangles.begin() + 200, mesh.triangles.begin() + 240);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 11) {
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  }
  const mesh::Triangle t = mesh.triangles[50];
  mesh.vertices.push_back(mesh.vertices[t[2]] + Vec3(1, 1, 1));
  mesh.triangles.push_back(
      {t[0], t[1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  mesh.triangles.push_back({t[0], t[1], t[1]});
  return mesh;
}

TEST(Sections, CuboidHasOneSquareAPlane) {
  SpacedCloud cloud;
  const auto statistics = Cut(Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 5)), Fine(0.5), cloud);
  // Extent 5, planes at 0.05 + k 0.5 up to 4.95: 10 of them.
  EXPECT_EQ(statistics.plane_count, 10u);
  EXPECT_EQ(statistics.closed_contour_count, 10u);
  EXPECT_EQ(statistics.open_contour_count, 0u);
  // Two faces of 100 mm^2 are parallel to the planes and lost.
  EXPECT_EQ(statistics.parallel_face_count, 2u);
  EXPECT_NEAR(statistics.parallel_area_mm2, 200, 1e-9);
  // 40 mm of contour at 0.5 mm, 0.4 % allowance: 79 points.
  EXPECT_EQ(statistics.point_count, 790u);
  for (const std::uint32_t source : cloud.source) EXPECT_EQ(source, 3u);
}

TEST(Sections, PlanesLieWhereTheyShould) {
  SpacedCloud cloud;
  SectionOptions options = Fine(0.3);
  options.first_last_distance_ratio = 0.5;
  Cut(Sphere(Vec3(5, 5, 5), 4, 40, 60), options, cloud);
  // From 1.15 to 8.85 mm: 25.7 layer distances, so 25 layers of 0.308 mm.
  for (const Vec3& p : cloud.points_mm) {
    const double k = (p.z() - 1 - 0.15) / 0.308;
    // The product guarantees 1 um; the arithmetic is far more accurate.
    EXPECT_NEAR(p.z(), 1 + 0.15 + std::round(k) * 0.308, 1e-6);
  }
}

// Annex B: First/Last Distance is that of both ends, 0.1 by default.
TEST(Sections, FirstAndLastDistanceAreKeptAtBothEnds) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> height_mm(2, 12), ratio(0, 1);
  for (int i = 0; i < 50; ++i) {
    SectionOptions options = Fine(0.7);
    options.first_last_distance_ratio = i == 0 ? 0.1 : ratio(random);
    const double inset_mm = 0.7 * options.first_last_distance_ratio;
    const double top_mm = 3 + height_mm(random);
    SpacedCloud cloud;
    Cut(Cuboid(Vec3(0, 0, 3), Vec3(5, 5, top_mm)), options, cloud);
    std::set<double> heights;
    for (const Vec3& p : cloud.points_mm) heights.insert(p.z());
    heights.erase(3);  // both faces are covered
    heights.erase(top_mm);
    ASSERT_GE(heights.size(), 2u);
    EXPECT_NEAR(*heights.begin(), 3 + inset_mm, 1e-9);
    EXPECT_NEAR(*heights.rbegin(), top_mm - inset_mm, 1e-9);
    const double layer_mm = (*std::next(heights.begin()) - *heights.begin());
    EXPECT_GE(layer_mm, 0.7);
    EXPECT_LT(layer_mm, 0.7 * (1 + 1.0 / static_cast<double>(heights.size() - 1)) + 1e-9);
  }
}

TEST(Sections, VerticesExactlyInAPlaneLeaveContoursClosed) {
  // Every plane goes through a ring of vertices of the sphere and of the torus.
  for (const auto& mesh :
       {Sphere(Vec3(0, 0, 0), 4, 16, 24), Torus(Vec3(0, 0, 0), 5, 2, 24, 16)}) {
    SectionOptions options = Fine(0.25);
    options.first_last_distance_ratio = 0;
    SpacedCloud cloud;
    EXPECT_EQ(Cut(mesh, options, cloud).open_contour_count, 0u);
  }
}

TEST(Sections, TorusHasTwoContoursInEveryPlane) {
  SpacedCloud cloud;
  const auto statistics = Cut(Torus(Vec3(0, 0, 0), 5, 2, 90, 60), Fine(0.1), cloud);
  EXPECT_EQ(statistics.closed_contour_count, 2 * statistics.plane_count);
}

TEST(Sections, PointsLieOnTheSurfaceForAnyDirection) {
  const auto mesh = Torus(Vec3(1, 2, 3), 5, 2, 24, 16);
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) {
    SectionOptions options = Fine(0.7);
    options.normal = {axis, Vec3(0.3, -0.8, 1.1)};
    SpacedCloud cloud;
    const auto statistics = Cut(mesh, options, cloud);
    EXPECT_EQ(statistics.open_contour_count, 0u);
    ASSERT_GT(cloud.size(), 50u);
    // Rounding of coordinates of about 10 mm.
    for (const Vec3& p : cloud.points_mm) EXPECT_LT(DistanceToMesh(p, mesh), 1e-12);
  }
}

TEST(Sections, SpacingAlongAContourIsEven) {
  SpacedCloud cloud;
  SectionOptions options = Fine(0.1);
  options.layer_distance_mm = 1;
  Cut(Sphere(Vec3(0, 0, 0), 5, 200, 400), options, cloud);
  std::map<double, PointList> planes;
  for (const Vec3& p : cloud.points_mm) planes[p.z()].push_back(p);
  for (const auto& [z, points] : planes) {
    if (points.size() < 200) continue;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double distance = (points[i] - points[i - 1]).norm();
      // 0.4 % allowance for chords and less than one part in the number of points.
      EXPECT_GE(distance, 0.1);
      EXPECT_LT(distance, 0.101);
    }
  }
}

TEST(Sections, OpenContoursKeepTheirEnds) {
  auto mesh = Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 5));
  // Without the face y = 10 (triangles 6 and 7) each contour is a U of 30 mm.
  mesh.triangles.erase(mesh.triangles.begin() + 6, mesh.triangles.begin() + 8);
  SpacedCloud cloud;
  const auto statistics = Cut(mesh, Fine(0.5), cloud);
  EXPECT_EQ(statistics.closed_contour_count, 0u);
  EXPECT_EQ(statistics.open_contour_count, statistics.plane_count);
  int ends = 0;
  for (const Vec3& p : cloud.points_mm) {
    if (p.y() == 10 && (p.x() == 0 || p.x() == 10)) ++ends;
  }
  EXPECT_EQ(ends, 2 * static_cast<int>(statistics.plane_count));
}

TEST(Sections, ProgressCanEndIt) {
  for (const double turn : {0.0, 0.3}) {
    SectionOptions options = Fine(0.1);
    options.normal.rotation_rad.x() = turn;
    const auto source = MakeSections(Cuboid(Vec3(0, 0, 0), Vec3(1, 1, 1)), options);
    SpacedCloud cloud;
    const auto result = (*source)->AddPoints(
        {}, 0, [](std::uint64_t, std::uint64_t) { return false; }, cloud);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kCancelled);
    EXPECT_EQ(cloud.size(), 0u);
  }
}

// Planes through rows of vertices, along edges and in whole faces of a divided cube.
TEST(Sections, PlanesThroughVerticesEdgesAndFacesCutOnce) {
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) {
    SectionOptions options = Fine(0.25);
    options.first_last_distance_ratio = 0;
    options.normal.axis = axis;
    // The pitch is above 0.25 by the rounding allowance: so are the cells.
    SpacedCloud cloud;
    const auto statistics = Cut(Cube(4 * kRoundingAllowance, 16), options, cloud);
    // The lowest plane passes below all vertices, the highest below the top face.
    EXPECT_EQ(statistics.closed_contour_count, 16u);
    EXPECT_EQ(statistics.open_contour_count, 0u);
    EXPECT_NEAR(statistics.parallel_area_mm2, 32, 1e-6);
  }
}

// The circle of radius sqrt(R^2 - z^2) in each plane has its length's worth of points.
TEST(Sections, PointCountsOfASphereAreThoseOfItsCircles) {
  const double radius = 10;
  SpacedCloud cloud;
  const auto statistics = Cut(Icosphere(radius, 5, Vec3(0, 0, 0)), Fine(0.2), cloud);
  EXPECT_EQ(statistics.closed_contour_count, statistics.plane_count);
  std::map<long, std::size_t> count;
  for (const Vec3& p : cloud.points_mm) ++count[std::lround(1e6 * p.z())];
  EXPECT_EQ(count.size(), statistics.plane_count);
  for (const auto& [z_nm, points] : count) {
    const double z = 1e-6 * static_cast<double>(z_nm);
    const double length = 2 * std::numbers::pi * std::sqrt(radius * radius - z * z);
    // 0.4 % allowance for chords, 0.3 % for the facets of 2 degrees, one point rounded
    // off.
    EXPECT_NEAR(static_cast<double>(points), length / 0.2, 1 + 0.01 * length / 0.2) << z;
  }
}

TEST(Sections, ATurnedModelCutAlongItsAxisGivesTheTurnedPoints) {
  const Direction direction{Axis::kX, Vec3(0.7, -0.4, 2.1)};
  const Mat3 turn = FrameOf(direction) * FrameOf({Axis::kX, Vec3::Zero()}).transpose();
  SectionOptions options = Fine(0.3);
  options.normal.axis = Axis::kX;
  const auto mesh = Rough();  // no two corners are equally far ahead
  SpacedCloud upright, turned;
  Cut(mesh, options, upright);
  options.normal = direction;
  Cut(Turned(mesh, turn), options, turned);
  ASSERT_EQ(upright.size(), turned.size());
  for (std::size_t i = 0; i < upright.size(); ++i) {
    // Rounding of the turned coordinates, of about 5 mm.
    EXPECT_LT((turn * upright.points_mm[i] - turned.points_mm[i]).norm(), 1e-11);
  }
}

// Upright planes cut the dome in arcs that end at its open rim, z = 0.
TEST(Sections, ArcsEndAtTheOpenRim) {
  const auto dome = OpenDome(5, 64, 16);
  SectionOptions options = Fine(0.3);
  options.normal.axis = Axis::kX;
  SpacedCloud with_ends, without;
  const auto statistics = Cut(dome, options, with_ends);
  EXPECT_EQ(statistics.open_contour_count, statistics.plane_count);
  EXPECT_EQ(statistics.closed_contour_count, 0u);
  options.insert_end_points = false;
  Cut(dome, options, without);
  const auto on_rim = [](const SpacedCloud& cloud) {
    return std::count_if(cloud.points_mm.begin(), cloud.points_mm.end(),
                         [](const Vec3& p) { return p.z() == 0; });
  };
  EXPECT_EQ(on_rim(with_ends), 2 * static_cast<long>(statistics.plane_count));
  EXPECT_EQ(on_rim(without), 0);
  EXPECT_LT(LargestDistanceToMesh(with_ends.points_mm, dome), 1e-12);
}

TEST(Sections, EachLayerIsTwistedByItsShareOfTheDistance) {
  SectionOptions options = Fine(0.5);
  options.twist_phase_ratio = 0.25;
  SpacedCloud straight, twisted;
  const auto statistics =
      Cut(Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 5)), Fine(0.5), straight);
  Cut(Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 5)), options, twisted);
  ASSERT_EQ(straight.size(), twisted.size());
  const std::size_t in_plane = straight.size() / statistics.plane_count;
  const double step = 40.0 / static_cast<double>(in_plane);
  for (std::size_t plane = 0; plane < statistics.plane_count; ++plane) {
    const double shift =
        (straight.points_mm[plane * in_plane] - twisted.points_mm[plane * in_plane])
            .norm();
    EXPECT_NEAR(shift, step * 0.25 * static_cast<double>(plane % 4), 1e-9);
  }
}

TEST(Sections, ContoursShorterThanTheDistanceGetOnePoint) {
  SectionOptions options = Fine(100);
  options.layer_distance_mm = 0.5;
  SpacedCloud cloud;
  const auto statistics = Cut(Icosphere(2, 3, Vec3(0, 0, 0)), options, cloud);
  EXPECT_EQ(cloud.size(), statistics.plane_count);
}

TEST(Sections, LostBasesOfACylinderAreMeasured) {
  SpacedCloud cloud;
  const auto statistics = Cut(Cylinder(5, 8, 90), Fine(0.5), cloud);
  const double polygon = 0.5 * 90 * 25 * std::sin(2 * std::numbers::pi / 90);
  EXPECT_NEAR(statistics.parallel_area_mm2, 2 * polygon, 1e-9);
}

TEST(Sections, AFlippedTriangleDoesNotOpenAContour) {
  auto mesh = Icosphere(4, 3, Vec3(0, 0, 0));
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 7) {
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  }
  SpacedCloud cloud;
  const auto statistics = Cut(mesh, Fine(0.3), cloud);
  EXPECT_EQ(statistics.open_contour_count, 0u);
  EXPECT_EQ(statistics.closed_contour_count, statistics.plane_count);
}

TEST(Sections, TooManyPlanesOrPointsAreAnError) {
  const auto planes = MakeSections(Cuboid(Vec3(0, 0, 0), Vec3(1e7, 1, 1e7)), Fine(0.01));
  ASSERT_FALSE(planes.has_value());
  EXPECT_EQ(planes.error().code, ErrorCode::kTooLarge);
  SectionOptions options = Fine(0.01);
  for (const Axis axis : {Axis::kX, Axis::kZ}) {
    options.normal.axis = axis;
    const auto points = MakeSections(Cuboid(Vec3(0, 0, 0), Vec3(1, 1e6, 1)), options);
    SpacedCloud cloud;
    const auto result = (*points)->AddPoints({}, 0, {}, cloud);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kTooLarge);
    EXPECT_EQ(cloud.size(), 0u);
  }
}

TEST(Sections, SlabsAreTheWhole) {
  for (const auto& mesh : {Rough(), Cuboid(Vec3(1, 1, 1), Vec3(11, 11, 9))}) {
    for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(0.01, 0, 0),
                             Vec3(0.3, -0.8, 1.1), Vec3(std::numbers::pi, 0, 0)}) {
      for (const Axis axis : {Axis::kX, Axis::kZ}) {
        SectionOptions options = Fine(0.1);
        options.layer_distance_mm = 0.25;
        options.twist_phase_ratio = 0.3;
        options.normal = {axis, turn};
        options.reference = SectionReference::kWorld;
        options.parallel_faces = ParallelFaces::kCover;
        const auto source = MakeSections(mesh, options);
        // Among them the height of a plane and that of the lowest point.
        ExpectSlabsAreTheWhole(
            **source, {(*source)->Bounds().min_mm.z(), 3.3, 4.0 * kRoundingAllowance, 4.1,
                       7.7, 8.25 * kRoundingAllowance, 9});
      }
    }
  }
}

TEST(Sections, PlanesOfTheWorldAreTheSameForAllModels) {
  SectionOptions options = Fine(0.3);
  options.reference = SectionReference::kWorld;
  for (const double base : {0.0, 1.234, 17.77}) {
    SpacedCloud cloud;
    const auto statistics = Cut(Icosphere(2, 4, Vec3(9, 9, base + 2)), options, cloud);
    std::set<double> heights;
    for (const Vec3& p : cloud.points_mm) heights.insert(p.z());
    // Multiples of the layer distance within the sphere less 0.03 mm at either end.
    const double first = std::ceil((base + 0.03) / 0.3),
                 last = std::floor((base + 3.97) / 0.3);
    EXPECT_EQ(statistics.plane_count, heights.size());
    EXPECT_EQ(static_cast<double>(heights.size()), last - first + 1);
    for (const double z : heights)
      EXPECT_EQ(z, std::round(z / 0.3) * (0.3 * kRoundingAllowance));
  }
}

TEST(Sections, AModelThinnerThanTwiceTheFirstDistanceGetsOnePlane) {
  SectionOptions options = Fine(1);
  options.first_last_distance_ratio = 0.6;
  SpacedCloud cloud;
  EXPECT_EQ(Cut(Cuboid(Vec3(0, 0, 3), Vec3(5, 5, 4)), options, cloud).plane_count, 1u);
  for (const Vec3& p : cloud.points_mm) EXPECT_EQ(p.z(), 3.5);
}

TEST(Sections, AxesOfTheObjectTurnWithIt) {
  const Mat3 turn = FrameOf({Axis::kZ, Vec3(0.5, 1.2, -2)});
  SectionOptions options = Fine(0.3);
  options.normal.axis = Axis::kX;
  const auto mesh = Rough();  // no two corners are equally far ahead
  SpacedCloud upright, turned;
  Cut(mesh, options, upright);
  options.object_axes = turn;
  Cut(Turned(mesh, turn), options, turned);
  ASSERT_EQ(upright.size(), turned.size());
  for (std::size_t i = 0; i < upright.size(); ++i) {
    EXPECT_LT((turn * upright.points_mm[i] - turned.points_mm[i]).norm(), 1e-11);
  }
}

// Both bases, for any direction, as evenly as equilateral triangles of the distance do.
TEST(Sections, ParallelFacesAreCovered) {
  const Vec3 size(8, 7, 3);
  const auto cuboid = Cuboid(Vec3(0, 0, 0), size);
  const auto divided = [&] {
    auto mesh = Cube(1, 9);
    for (Vec3& v : mesh.vertices) v = v.cwiseProduct(size);
    return mesh;
  }();
  for (const auto& mesh : {cuboid, divided}) {
    for (const Vec3& turn_rad : {Vec3(0, 0, 0), Vec3(0.3, 0.2, 0.1)}) {
      const Direction direction = {Axis::kZ, turn_rad};
      const Mat3 turn = FrameOf(direction);
      const auto turned = Turned(mesh, turn);
      SectionOptions options = Fine(0.2);
      options.normal = direction;
      SpacedCloud without, with;
      Cut(turned, options, without);
      options.parallel_faces = ParallelFaces::kCover;
      const auto statistics = Cut(turned, options, with);
      EXPECT_EQ(statistics.parallel_face_count, 2u);
      EXPECT_NEAR(statistics.parallel_area_mm2, 112, 1e-6);
      PointList cover;
      for (const Vec3& p : with.points_mm) {
        const double w = turn.col(2).dot(p);
        if (std::min(std::abs(w), std::abs(w - size.z())) < 1e-9) cover.push_back(p);
      }
      EXPECT_EQ(cover.size(), with.size() - without.size());
      EXPECT_GE(MinDistance(cover), 0.2);
      // A point has 0.2^2 sin 60 of the area; those at the sides count or do not.
      EXPECT_NEAR(static_cast<double>(cover.size()), 112 / (0.04 * std::sqrt(0.75)),
                  2 * 30 / 0.2);
      // Corners of the faces are the farthest from the grid and near to a contour.
      EXPECT_LT(LargestGap(turned, with.points_mm, 0.07), 0.2);
      options.parallel_faces = ParallelFaces::kIgnore;
      SpacedCloud ignored;
      EXPECT_EQ(Cut(turned, options, ignored).parallel_area_mm2, 0);
      EXPECT_EQ(ignored.size(), without.size());
    }
  }
}

// Along the arc, not the chord: with 400 facets of a circle the difference is negligible.
TEST(Sections, SpacingIsWithinOnePerCentOfItsMean) {
  SectionOptions options = Fine(0.1);
  options.layer_distance_mm = 0.37;
  SpacedCloud cloud;
  Cut(Torus(Vec3(0, 0, 0), 5, 2, 400, 200), options, cloud);
  std::size_t pairs = 0;
  for (std::size_t i = 1; i + 1 < cloud.size(); ++i) {
    const Vec3 &a = cloud.points_mm[i - 1], &b = cloud.points_mm[i],
               &c = cloud.points_mm[i + 1];
    if (a.z() != b.z() || b.z() != c.z() || (a - c).norm() > 0.3) continue;
    EXPECT_NEAR((b - a).norm() / (c - b).norm(), 1, 0.01);
    ++pairs;
  }
  EXPECT_GT(pairs, cloud.size() * 9 / 10);
}

TEST(Sections, NothingComesOfAnEmptyMesh) {
  SpacedCloud cloud;
  EXPECT_EQ(Cut({}, Fine(1), cloud).point_count, 0u);
}

}  // namespace
}  // namespace intaglio::discretize
