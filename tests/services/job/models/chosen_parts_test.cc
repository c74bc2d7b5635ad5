// Parts of a model's file, spacings of its own, and blocks that were turned.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/services/job/models/one_model.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;

TEST(ModelSources, AnObjectOfAFileLiesInItsPlaceOfTheWholeFile) {
  constexpr std::string_view kTwo =
      "o left\nv 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n"
      "o right\nv 10 0 2\nv 14 0 2\nv 10 4 2\nf 4 5 6\n";
  OneModel one;
  one.model.set_file("two.obj");
  one.model.mutable_placement()->set_centre_in_block(false);
  one.model.mutable_placement()->mutable_move_mm()->set_x(5);
  one.model.mutable_placement()->mutable_move_mm()->set_y(5);
  one.model.mutable_placement()->mutable_move_mm()->set_z(5);
  one.model.mutable_fill()->set_vertex_distance_mm(0.5);
  const auto all = one.Make({kTwo});
  ASSERT_TRUE(all.has_value()) << all.error().message;
  one.model.add_objects("right");
  const auto right = one.Make({kTwo});
  ASSERT_TRUE(right.has_value()) << right.error().message;
  Box3 box;
  for (const Vec3& p : right->cloud.points_mm) box.Extend(p);
  EXPECT_TRUE(box.min_mm.isApprox(Vec3(15, 5, 7), 0.02)) << box.min_mm.transpose();
  EXPECT_TRUE(box.max_mm.isApprox(Vec3(19, 9, 7), 0.02)) << box.max_mm.transpose();
  EXPECT_EQ(2 * right->cloud.size(), all->cloud.size());
  one.model.add_objects("Left");
  const auto unknown = one.Make({kTwo});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_THAT(unknown.error().message,
              HasSubstr("no object \"Left\" with faces; its objects are \"left\", "
                        "\"right\""));
}

// Centred and fitted, as by default: they would lie over each other, each as large as
// the whole.
TEST(ModelSources, ObjectsOfAFileKeepTheirPlacesAmongEachOther) {
  constexpr std::string_view kTwo =
      "o left\nv 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n"
      "o right\nv 10 0 2\nv 14 0 2\nv 10 4 2\nf 4 5 6\n";
  OneModel one;
  one.model.set_file("two.obj");
  one.model.mutable_placement()->set_fit_size_mm(28);  // twice as large
  one.model.mutable_placement()->mutable_rotate_deg()->set_z(90);
  one.model.mutable_fill()->set_vertex_distance_mm(0.5);
  const auto box_of = [&](const char* object) {
    one.model.clear_objects();
    if (object != nullptr) one.model.add_objects(object);
    const auto made = one.Make({kTwo});
    EXPECT_TRUE(made.has_value()) << made.error().message;
    Box3 box;
    if (made) {
      for (const Vec3& p : made->cloud.points_mm) box.Extend(p);
    }
    return box;
  };
  const Box3 whole = box_of(nullptr), left = box_of("left"), right = box_of("right");
  EXPECT_TRUE(whole.size_mm().isApprox(Vec3(8, 28, 4), 0.02));
  EXPECT_TRUE((right.min_mm - left.min_mm).isApprox(Vec3(0, 20, 4), 0.02))
      << right.min_mm.transpose();
  EXPECT_TRUE(left.min_mm.isApprox(whole.min_mm, 0.02));
  EXPECT_TRUE(right.max_mm.isApprox(whole.max_mm, 0.02));
}

TEST(ModelSources, ACloudIsThinnedToItsOwnSpacing) {
  std::string row;
  for (int i = 0; i < 21; ++i) row += std::to_string(i) + " 0 0\n";
  OneModel one;
  one.model.set_file("row.xyz");
  one.model.mutable_placement()->mutable_move_mm()->set_x(10);
  one.model.mutable_placement()->mutable_move_mm()->set_y(10);
  one.model.mutable_placement()->mutable_move_mm()->set_z(10);
  EXPECT_EQ(one.Make({row})->cloud.size(), 21u);
  one.model.set_min_spacing_mm(1);
  EXPECT_EQ(one.Make({row})->cloud.size(), 21u) << "exactly so far apart";
  one.model.set_min_spacing_mm(1.5);
  EXPECT_EQ(one.Make({row})->cloud.size(), 11u);
  // A PLY that turns out to be a mesh.
  one.model.set_file("face.ply");
  const auto mesh = one.Make(
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
       "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"});
  ASSERT_FALSE(mesh.has_value());
  EXPECT_THAT(mesh.error().message, HasSubstr("the file is a mesh"));
}

// Against a turn of the finished points about the block's corner, by hand.
TEST(ModelSources, ABlockThatWasTurnedHasItsModelsTurnedWithIt) {
  OneModel one;
  one.model.set_file("three.xyz");
  Vector3& size = *one.job.mutable_block()->mutable_size_mm();
  size.set_x(50), size.set_y(40), size.set_z(30);
  Placement& placement = *one.model.mutable_placement();
  placement.mutable_rotate_deg()->set_z(30);
  placement.mutable_move_mm()->set_x(20);
  placement.mutable_move_mm()->set_y(7);
  placement.mutable_move_mm()->set_z(6);
  one.model.mutable_copies()->set_count_x(3);
  one.model.mutable_copies()->mutable_step_mm()->set_x(5);
  for (const bool centred : {false, true}) {
    placement.set_centre_in_block(centred);
    placement.mutable_move_mm()->set_z(centred ? 0 : 6);
    placement.mutable_move_mm()->set_x(centred ? -3 : 20);
    one.job.mutable_block()->set_quarter_turns(0);
    size.set_x(50), size.set_y(40);
    const auto before = one.Make({kThreePoints});
    ASSERT_TRUE(before.has_value()) << before.error().message;
    for (const int turns : {1, 2, 3}) {
      one.job.mutable_block()->set_quarter_turns(turns);
      size.set_x(turns % 2 == 0 ? 50 : 40), size.set_y(turns % 2 == 0 ? 40 : 50);
      const auto turned = one.Make({kThreePoints});
      ASSERT_TRUE(turned.has_value()) << turned.error().message;
      ASSERT_EQ(turned->cloud.size(), before->cloud.size());
      for (const Vec3& p : before->cloud.points_mm) {
        // Counterclockwise; the block comes back beside the axes.
        const Vec3 expected = turns == 1   ? Vec3(40 - p.y(), p.x(), p.z())
                              : turns == 2 ? Vec3(50 - p.x(), 40 - p.y(), p.z())
                                           : Vec3(p.y(), 50 - p.x(), p.z());
        EXPECT_TRUE(std::ranges::any_of(
            turned->cloud.points_mm,
            [&](const Vec3& q) { return (q - expected).norm() < 1e-9; }))
            << turns << ": " << expected.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace intaglio
