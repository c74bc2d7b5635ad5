#include "engrave/mesh/placement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "engrave/core/check.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kBlock(60, 80, 100);
// Sizes up to 1000 mm in doubles: a few roundings of 1e-13 mm, far under a nanometre.
constexpr double kRoundingMm = 1e-11;

/// The steps of the header, one after another on a point, with textbook rotations.
Vec3 PlaceBySteps(Vec3 p, const Placement& placement) {
  p *= placement.unit_mm;
  p = UprightFrom(placement.up) * p;
  if (placement.mirror_x) p.x() = -p.x();
  if (placement.mirror_y) p.y() = -p.y();
  if (placement.mirror_z) p.z() = -p.z();
  p = p.cwiseProduct(placement.scale_ratio);
  const auto turn = [](double& u, double& v, double angle_rad) {
    const double u_before = u;
    u = u_before * std::cos(angle_rad) - v * std::sin(angle_rad);
    v = u_before * std::sin(angle_rad) + v * std::cos(angle_rad);
  };
  turn(p.y(), p.z(), placement.rotation_rad.x());
  turn(p.z(), p.x(), placement.rotation_rad.y());
  turn(p.x(), p.y(), placement.rotation_rad.z());
  return p;
}

double WallGapDifference_mm(const Box3& box, const Vec3& block_size_mm) {
  return ((box.min_mm - Vec3::Zero()) - (block_size_mm - box.max_mm))
      .cwiseAbs()
      .maxCoeff();
}

TEST(Placement, WithoutCentringAppliesTheStepsInTheirOrder) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  std::uniform_real_distribution<double> ratio(0.2, 5);
  const TriangleMesh mesh = BoxMesh({1, 2, 3});
  for (int round = 0; round < 100; ++round) {
    Placement placement;
    placement.unit_mm = ratio(random);
    placement.up = static_cast<UpAxis>(random() % 6);
    placement.mirror_x = random() % 2;
    placement.mirror_y = random() % 2;
    placement.mirror_z = random() % 2;
    placement.scale_ratio = {ratio(random), ratio(random), ratio(random)};
    placement.rotation_rad = {angle(random), angle(random), angle(random)};
    placement.move_mm = {ratio(random), -ratio(random), 10};
    placement.centre_in_block = false;
    const auto placed = PlaceInBlock(mesh, placement, kBlock);
    ASSERT_TRUE(placed.has_value());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Vec3 expected = PlaceBySteps(mesh.vertices[v], placement) + placement.move_mm;
      EXPECT_LT((placed->vertices[v] - expected).norm(), kRoundingMm);
    }
    // The volume is stretched and, because mirroring reverses the corners, positive.
    const double stretch = std::pow(placement.unit_mm, 3) * placement.scale_ratio.prod();
    EXPECT_NEAR(Diagnose(*placed).signed_volume_mm3, 6 * stretch, 1e-9 * stretch);
  }
}

TEST(Placement, DefaultCentresTheModelInTheBlock) {
  const auto placed = PlaceInBlock(BoxMesh({10, 20, 30}), {}, kBlock);
  ASSERT_TRUE(placed.has_value());
  EXPECT_EQ(placed->Bounds().min_mm, Vec3(25, 30, 35));
  EXPECT_EQ(placed->Bounds().max_mm, Vec3(35, 50, 65));
}

TEST(Placement, CentresTheOutermostPointsWhateverTheTurn) {
  Placement placement;
  placement.rotation_rad = {0.3, -1.1, 2.5};
  const auto placed = PlaceInBlock(BoxMesh({10, 20, 30}), placement, kBlock);
  ASSERT_TRUE(placed.has_value());
  EXPECT_LT(WallGapDifference_mm(placed->Bounds(), kBlock), kRoundingMm);
}

TEST(Placement, MovesFromTheCentre) {
  Placement placement;
  placement.move_mm = {1, -2, 3};
  const auto placed = PlaceInBlock(BoxMesh({10, 20, 30}), placement, kBlock);
  ASSERT_TRUE(placed.has_value());
  EXPECT_EQ(placed->Bounds().center_mm(), Vec3(31, 38, 53));
}

TEST(Placement, QuarterTurnsKeepABoxExact) {
  Placement placement;
  placement.rotation_rad = {90 * kPi / 180, 0, -90 * kPi / 180};
  placement.centre_in_block = false;
  const auto placed = PlaceInBlock(BoxMesh({1, 2, 3}), placement, kBlock);
  ASSERT_TRUE(placed.has_value());
  // About x: (x, y, z) -> (x, -z, y); then about z by -90: (x, y, z) -> (y, -x, z).
  EXPECT_EQ(placed->vertices[7], Vec3(-3, -1, 2));
}

TEST(Placement, FitsTheHeightAfterTurning) {
  Placement placement;
  placement.rotation_rad = {kPi / 2, 0, 0};  // the y extent, 2, becomes the height
  placement.fit = FitHeight{40};
  const auto placed = PlaceInBlock(BoxMesh({1, 2, 3}), placement, kBlock);
  ASSERT_TRUE(placed.has_value());
  EXPECT_LT((placed->Bounds().size_mm() - Vec3(20, 60, 40)).norm(), kRoundingMm);
}

TEST(Placement, FitsTheLargestExtentWhateverTheUnit) {
  for (const double unit_mm : {0.001, 1.0, 25.4, 1000.0}) {
    Placement placement;
    placement.unit_mm = unit_mm;
    placement.fit = FitLargest{50};
    const auto placed = PlaceInBlock(BoxMesh({1, 2, 4}), placement, kBlock);
    ASSERT_TRUE(placed.has_value());
    EXPECT_LT((placed->Bounds().size_mm() - Vec3(12.5, 25, 50)).norm(), kRoundingMm);
  }
}

TEST(Placement, FillsTheBoxUpToItsTightestSide) {
  Placement placement;
  placement.fit = FitBox{kBlock - Vec3::Constant(6)};  // 54 x 74 x 94
  const auto placed = PlaceInBlock(BoxMesh({2, 1, 3}), placement, kBlock);
  ASSERT_TRUE(placed.has_value());
  EXPECT_LT((placed->Bounds().size_mm() - Vec3(54, 27, 81)).norm(), kRoundingMm);
  EXPECT_NEAR(placed->Bounds().min_mm.x(), 3, kRoundingMm);
}

TEST(Placement, MirrorTwiceKeepsTheCornersAndOnceReversesThem) {
  const TriangleMesh mesh = BoxMesh({1, 2, 3});
  Placement twice;
  twice.mirror_x = twice.mirror_z = true;
  EXPECT_EQ(PlaceInBlock(mesh, twice, kBlock)->triangles, mesh.triangles);
  Placement once;
  once.mirror_y = true;
  const auto placed = PlaceInBlock(mesh, once, kBlock);
  EXPECT_EQ(placed->triangles[0], (Triangle{0, 3, 2}));
  EXPECT_EQ(Diagnose(*placed).signed_volume_mm3, 6);
}

TEST(Placement, TransformIsTheOneThatIsApplied) {
  Placement placement;
  placement.rotation_rad = {0.1, 0.2, 0.3};
  placement.fit = FitHeight{33};
  const TriangleMesh mesh = BoxMesh({1, 2, 3});
  const auto transform = GlassFromModelOf(mesh.vertices, placement, kBlock);
  const auto placed = PlaceInBlock(mesh, placement, kBlock);
  ASSERT_TRUE(transform.has_value());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_EQ(transform->Apply(mesh.vertices[v]), placed->vertices[v]);
  }
}

TEST(Placement, FlatModelCannotBeFittedToAHeight) {
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}};
  Placement placement;
  placement.fit = FitHeight{40};
  const auto placed = PlaceInBlock(flat, placement, kBlock);
  ASSERT_FALSE(placed.has_value());
  EXPECT_EQ(placed.error().code, ErrorCode::kInvalidValue);
  EXPECT_NE(placed.error().message.find("no height"), std::string::npos);
  placement.fit = FitBox{{10, 10, 10}};
  EXPECT_TRUE(PlaceInBlock(flat, placement, kBlock).has_value());
}

TEST(Placement, SizeBeyondAllNumbersIsAnError) {
  Placement placement;
  placement.unit_mm = 1e300;
  placement.scale_ratio = {1e300, 1, 1};
  EXPECT_FALSE(PlaceInBlock(BoxMesh({1, 1, 1}), placement, kBlock).has_value());
}

TEST(Placement, RefusesValuesOutsideTheirRanges) {
  const TriangleMesh mesh = BoxMesh({1, 1, 1});
  Placement placement;
  placement.unit_mm = 0;
  EXPECT_THROW((void)PlaceInBlock(mesh, placement, kBlock), PreconditionError);
  placement = {};
  placement.scale_ratio.y() = -1;
  EXPECT_THROW((void)PlaceInBlock(mesh, placement, kBlock), PreconditionError);
  placement = {};
  placement.fit = FitHeight{0};
  EXPECT_THROW((void)PlaceInBlock(mesh, placement, kBlock), PreconditionError);
  EXPECT_THROW((void)PlaceInBlock({}, Placement{}, kBlock), PreconditionError);
}

TEST(Placement, ThePivotStaysWhereItIs) {
  const PointList vertices = {{1, 2, 3}, {5, 2, 3}, {1, 8, 4}};
  Placement placement;
  placement.unit_mm = 2;
  placement.centre_in_block = false;
  placement.rotation_rad = Vec3(0.3, -0.7, 1.1);
  placement.fit = FitLargest{40};
  placement.mirror_y = true;
  const Vec3 object_mm = 2 * Vec3(3, 5, 3.5);
  const std::pair<Pivot, Vec3> cases[] = {{Pivot::kOrigin, Vec3::Zero()},
                                          {Pivot::kObject, object_mm},
                                          {Pivot::kBlock, 0.5 * kBlock}};
  for (const auto& [pivot, at_mm] : cases) {
    placement.pivot = pivot;
    const auto transform = GlassFromModelOf(vertices, placement, kBlock);
    ASSERT_TRUE(transform.has_value());
    EXPECT_LT((transform->Apply(at_mm / placement.unit_mm) - at_mm).norm(), kRoundingMm);
  }
}

// Placed in the block before, and turned with it by the definition of a turn.
TEST(Placement, IsTurnedWithItsBlock) {
  const TriangleMesh mesh = BoxMesh({1, 2, 3});
  Placement placement;
  placement.rotation_rad = {0.3, -0.4, 0.5};
  placement.move_mm = {4, -5, 6};
  placement.fit = FitBox{{20, 30, 40}};
  for (const bool centred : {false, true}) {
    placement.centre_in_block = centred;
    placement.pivot = Pivot::kBlock;
    placement.quarter_turns = 0;
    const auto before = PlaceInBlock(mesh, placement, kBlock);
    Mat3 turn = Mat3::Identity();
    Mat3 once;
    once << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    for (placement.quarter_turns = 1; placement.quarter_turns < 4;
         ++placement.quarter_turns) {
      turn = once * turn;
      const bool is_odd = placement.quarter_turns % 2 != 0;
      const Vec3 block = is_odd ? Vec3(kBlock.y(), kBlock.x(), kBlock.z()) : kBlock;
      const auto placed = PlaceInBlock(mesh, placement, block);
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vec3 expected = turn * (before->vertices[v] - 0.5 * kBlock) + 0.5 * block;
        EXPECT_LT((placed->vertices[v] - expected).norm(), kRoundingMm);
      }
      EXPECT_TRUE(ObjectAxesOf(placement).isApprox(
          turn * RotationOf(placement.rotation_rad), 1e-15));
    }
  }
}

}  // namespace
}  // namespace intaglio::mesh
