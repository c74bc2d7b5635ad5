// The message of a method of meshes means the options of engrave/ that are written out
// here: the points of both are the same, bit for bit.

#include <gtest/gtest.h>

#include <numbers>
#include <utility>
#include <variant>

#include "engrave/discretize/mesh/even.h"
#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/mesh/solid.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/fields/shapes.h"
#include "services/job/methods/method_table.h"
#include "services/job/methods/point_maker.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/source_checks.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

// Its spacing is 0.3 mm.
class MeshMethod : public testing::Test {
 protected:
  using Points = decltype(discretize::Sorted({}));

  static mesh::TriangleMesh Shape() {
    // Faces in every direction, none of them in a plane of a section; and a flat one.
    mesh::TriangleMesh shape = discretize::Icosphere(3, 3, Vec3(20, 20, 15));
    for (Vec3& v : shape.vertices) v.z() = std::max(v.z(), 13.0);
    return shape;
  }

  static Points PointsOf(const MadePoints& source) {
    discretize::SpacedCloud points;
    EXPECT_TRUE(source.value()->AddPoints({}, 0, {}, points).has_value());
    EXPECT_GT(points.size(), 50u);
    return discretize::Sorted(points);
  }

  /// Makes the points of the job as it is, its defaults filled in.
  Points Made(std::map<std::string_view, image::GreyImage> images = {}) const {
    const JobSpec whole = WithDefaults(job_, GoodMachine());
    const Model& model = whole.models(0);
    const MethodInput input{whole, model, PlacementOf(model.placement(), whole.block()),
                            BlockSizeOf(whole), std::move(images)};
    return PointsOf(std::get<MeshMaker>(MakerOf(*MethodOf(model)).make)(input, Shape()));
  }

  JobSpec job_ = GoodJob();
  Discretization& asked_ = *job_.mutable_discretization();
};

TEST_F(MeshMethod, OfSectionsHasAllItsOptions) {
  discretize::SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = 0.3;
  options.first_last_distance_ratio = 0.1;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeSections(Shape(), options)));

  SectionsMethod& sections = *asked_.mutable_sections();
  sections.set_axis(AXIS_X);
  sections.mutable_rotate_deg()->set_y(30);
  sections.set_layer_distance_mm(0.5);
  sections.set_vertex_distance_mm(0.4);
  sections.set_first_last_distance_ratio(0.4);
  sections.set_twist_phase_ratio(0.25);
  sections.set_insert_end_points(false);
  sections.set_system(COORDINATE_SYSTEM_WORLD);
  sections.set_parallel_faces(PARALLEL_FACES_REPORT);
  options.normal = {discretize::Axis::kX, Vec3(0, std::numbers::pi / 6, 0)};
  options.layer_distance_mm = 0.5;
  options.vertex_distance_mm = 0.4;
  options.first_last_distance_ratio = 0.4;
  options.twist_phase_ratio = 0.25;
  options.insert_end_points = false;
  options.reference = discretize::SectionReference::kWorld;
  options.parallel_faces = discretize::ParallelFaces::kReport;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeSections(Shape(), options)));
}

TEST_F(MeshMethod, OfSectionsTurnsItsAxesWithTheObject) {
  Placement& placement = *job_.mutable_models(0)->mutable_placement();
  placement.mutable_rotate_deg()->set_x(40);
  SectionsMethod& sections = *asked_.mutable_sections();
  discretize::SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = 0.3;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeSections(Shape(), options)));
  sections.set_system(COORDINATE_SYSTEM_OBJECT);
  options.object_axes = mesh::RotationOf(Vec3(40 * std::numbers::pi / 180, 0, 0));
  const Points turned = Made();
  EXPECT_EQ(turned, PointsOf(discretize::MakeSections(Shape(), options)));
  sections.clear_system();
  EXPECT_NE(turned, Made());
}

TEST_F(MeshMethod, OfFillHasAllItsOptions) {
  asked_.mutable_fill();
  EXPECT_EQ(Made(), PointsOf(discretize::MakeFill(Shape(), {0.3, true})));
  asked_.mutable_fill()->set_vertex_distance_mm(0.7);
  asked_.mutable_fill()->set_full_fill(false);
  EXPECT_EQ(Made(), PointsOf(discretize::MakeFill(Shape(), {0.7, false})));
}

TEST_F(MeshMethod, OfRaysHasAllItsOptions) {
  asked_.mutable_rays();
  discretize::RayOptions options;
  options.distance_mm = 0.3;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeRays(Shape(), options)));
  asked_.mutable_rays()->set_distance_mm(0.5);
  asked_.mutable_rays()->set_axis(AXIS_Y);
  asked_.mutable_rays()->mutable_rotate_deg()->set_z(45);
  asked_.mutable_rays()->set_interior_only(true);
  options = {0.5, {discretize::Axis::kY, Vec3(0, 0, std::numbers::pi / 4)}, true};
  EXPECT_EQ(Made(), PointsOf(discretize::MakeRays(Shape(), options)));
}

TEST_F(MeshMethod, OfRaysHasItsSystems) {
  Placement& placement = *job_.mutable_models(0)->mutable_placement();
  placement.mutable_rotate_deg()->set_x(40);
  RaysMethod& rays = *asked_.mutable_rays();
  discretize::RayOptions options;
  options.distance_mm = 0.3;
  rays.set_system(COORDINATE_SYSTEM_WORLD);
  options.grid_through_origin = true;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeRays(Shape(), options)));
  rays.set_system(COORDINATE_SYSTEM_OBJECT);
  options.grid_through_origin = false;
  options.axes = mesh::RotationOf(Vec3(40 * std::numbers::pi / 180, 0, 0));
  EXPECT_EQ(Made(), PointsOf(discretize::MakeRays(Shape(), options)));
}

TEST_F(MeshMethod, OfEvenHasAllItsOptions) {
  EvenMethod& even = *asked_.mutable_even();
  discretize::EvenOptions options;
  options.distance_mm = 0.3;
  EXPECT_EQ(Made(), PointsOf(discretize::MakeEven(Shape(), options)));
  even.set_distance_mm(0.4);
  even.add_shell_depths_mm(0.6);
  even.set_sparse_distance_mm(0.9);
  even.set_curvature_radius_mm(2.5);
  options.distance_mm = 0.4;
  options.sparse_distance_mm = 0.9;
  options.surface = false;
  options.depths_mm = {0.6};
  options.density = discretize::DensityByCurvature(Shape(), 0.4);
  EXPECT_EQ(Made(), PointsOf(discretize::MakeEven(Shape(), options)));
  even.add_shell_depths_mm(0);
  even.mutable_light()->set_x(-1);
  options.surface = true;
  options.density = discretize::DensityByLight(Shape(), Vec3(-1, 0, 0));
  EXPECT_EQ(Made(), PointsOf(discretize::MakeEven(Shape(), options)));
}

// The left half is black, the right one white.
TEST_F(MeshMethod, OfEvenIsSparseWhereItsImageIsDark) {
  image::GreyImage image{2, 1, {0, image::GreyImage::kWhite}};
  asked_.mutable_even()->set_image("shade.png");
  std::size_t left_count = 0, right_count = 0;
  for (const auto& [z, y, x, spacing_mm] : Made({{"image", image}})) {
    if (x < 18.5) left_count += spacing_mm > 0.8F;  // 3 times 0.3 is the sparsest
    if (x > 21.5) right_count += spacing_mm < 0.31F;
  }
  EXPECT_GT(left_count, 50u);
  EXPECT_GT(right_count, 50u);
}

TEST_F(MeshMethod, OfSolidHasAllItsOptions) {
  asked_.mutable_solid();
  EXPECT_EQ(Made(), PointsOf(discretize::MakeSolid(Shape(), {0.3, 1})));
  asked_.mutable_solid()->set_distance_mm(0.4);
  asked_.set_height_ratio(1.5);
  EXPECT_EQ(Made(), PointsOf(discretize::MakeSolid(Shape(), {0.4, 1.5})));
}

TEST_F(MeshMethod, OfTheModelIsTakenBeforeThatOfTheJob) {
  asked_.mutable_rays();
  job_.mutable_models(0)->mutable_fill()->set_vertex_distance_mm(0.7);
  EXPECT_EQ(Made(), PointsOf(discretize::MakeFill(Shape(), {0.7, true})));
}

}  // namespace
}  // namespace intaglio
