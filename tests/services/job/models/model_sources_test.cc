#include "services/job/models/model_sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "tests/services/job/models/one_model.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;

TEST(ModelSources, ACloudIsTakenAsItIs) {
  OneModel one;
  one.model.set_file("three.xyz");
  one.model.mutable_placement()->set_centre_in_block(false);
  one.model.mutable_placement()->mutable_move_mm()->set_x(5);
  one.model.mutable_placement()->mutable_move_mm()->set_y(6);
  one.model.mutable_placement()->mutable_move_mm()->set_z(7);
  const auto made = one.Make({kThreePoints});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_EQ(made->cloud.points_mm, (PointList{{5, 6, 7}, {6, 6, 7}, {5, 6, 9}}));
}

TEST(ModelSources, CopiesLieInAGridAboutTheMiddle) {
  OneModel one;
  one.model.set_file("three.xyz");
  one.model.mutable_placement()->set_centre_in_block(true);
  one.model.mutable_copies()->set_count_x(3);
  one.model.mutable_copies()->set_count_y(2);
  one.model.mutable_copies()->mutable_step_mm()->set_x(4);
  one.model.mutable_copies()->mutable_step_mm()->set_y(5);
  const auto made = one.Make({kThreePoints});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_EQ(made->cloud.size(), 18u);
  Box3 box;
  for (const Vec3& p : made->cloud.points_mm) box.Extend(p);
  EXPECT_NEAR(box.size_mm().x(), 1 + 2 * 4, 1e-12);
  EXPECT_NEAR(box.size_mm().y(), 5, 1e-12);
  EXPECT_TRUE(box.center_mm().isApprox(Vec3(25, 25, 15), 1e-12));
}

TEST(ModelSources, WhatAPlyWasTakenForIsANote) {
  OneModel one;
  one.model.set_file("/shop/scan.ply");
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\n"
      "property double y\nproperty double z\n";
  const std::string points = "end_header\n0 0 0\n3 0 0\n0 3 0\n";
  const auto warnings_of = [&](const std::string& file) {
    std::vector<FileBytes> bytes{BytesOf(file)};
    auto sources =
        MakeSources(WithDefaults(one.job, GoodMachine()), std::move(bytes), {}, {});
    EXPECT_TRUE(sources.has_value()) << sources.error().message;
    return sources ? sources->warnings : Warnings();
  };
  const Warnings cloud = warnings_of(head + points);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud[0].code, WarningCode::kChosen);
  EXPECT_EQ(cloud[0].weight, WarningWeight::kNote);
  EXPECT_EQ(
      cloud[0].text,
      "scan.ply: read as a cloud of points, because its header has no faces (element "
      "face, tristrips or range_grid), but vertex");
  const Warnings mesh =
      warnings_of(head + "element face 1\nproperty list uchar int vertex_indices\n" +
                  points + "3 0 1 2\n");
  ASSERT_FALSE(mesh.empty());
  EXPECT_EQ(mesh[0].text,
            "scan.ply: read as a mesh, because its header has 1 of element face");
  // Faces of a name that is not known are no reason to drop them.
  const std::string unknown = head +
                              "element polygon 1\nproperty list uchar int corners\n" +
                              points + "3 0 1 2\n";
  const auto refused = one.Make({unknown});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("its element polygon has lists"));
}

TEST(ModelSources, APlyWithoutFacesIsACloud) {
  OneModel one;
  one.model.set_file("scan.ply");
  const auto made = one.Make(
      {"ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double "
       "y\nproperty double z\nend_header\n0 0 0\n3 0 0\n"});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_EQ(made->cloud.size(), 2u);
  // A comment about faces is no list of them; triangle strips are.
  const std::string head = "ply\nformat ascii 1.0\ncomment element face 3\n";
  const std::string points =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string rows = "end_header\n0 0 0\n3 0 0\n";
  const auto commented = one.Make({head + points + rows});
  ASSERT_TRUE(commented.has_value()) << commented.error().message;
  EXPECT_EQ(commented->cloud.size(), 2u);
  const std::string strips =
      head + "element vertex 3" + points.substr(points.find('\n')) +
      "element tristrips 1\nproperty list int int vertex_indices\n" + rows +
      "0 3 0\n3 0 1 2\n";
  const JobSpec whole = WithDefaults(one.job, GoodMachine());
  const auto sources = MakeSources(whole, {BytesOf(strips)}, {}, {});
  ASSERT_TRUE(sources.has_value()) << sources.error().message;
  EXPECT_EQ(sources->meshes.size(), 1u);
}

TEST(ModelSources, ErrorsNameTheModelsFile) {
  OneModel one;
  one.model.set_file("three.xyz");
  const auto made = one.Make({"0 0\n"});
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().message, HasSubstr("three.xyz"));
}

// A text is seen in the drawing and missed in the glass; an invisible line is not.
TEST(ModelSources, WhatADrawingShowsAndIsLeftOutIsAWarningAndTheRestANote) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->Clear();
  job.mutable_models(0)->set_file("plate.svg");
  const auto sources = MakeSources(
      WithDefaults(job, GoodMachine()),
      {BytesOf("<svg xmlns='http://www.w3.org/2000/svg' width='10mm' height='10mm' "
               "viewBox='0 0 10 10'><line x1='0' y1='0' x2='9' y2='9' stroke='red'/>"
               "<line x1='0' y1='9' x2='9' y2='0' display='none'/>"
               "<text x='1' y='1'>Anna</text></svg>")},
      {}, {});
  ASSERT_TRUE(sources) << sources.error().message;
  ASSERT_EQ(sources->warnings.size(), 2u);
  EXPECT_THAT(sources->warnings[0].text, HasSubstr("plate.svg: 1 x invisible"));
  EXPECT_EQ(sources->warnings[0].weight, WarningWeight::kNote);
  EXPECT_THAT(sources->warnings[1].text, HasSubstr("1 x text (line 1, text): left out"));
  EXPECT_EQ(sources->warnings[1].weight, WarningWeight::kWarning);
  EXPECT_EQ(sources->warnings[1].code, WarningCode::kLeftOut);
}

TEST(ModelSources, AModelsOwnMethodIsUsed) {
  const std::string_view tetrahedron =
      "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  std::vector<std::size_t> counts;
  for (int i = 0; i < 2; ++i) {
    OneModel one;
    one.model.set_file("corner.obj");
    if (i == 1) one.model.mutable_rays()->set_distance_mm(2);
    const auto made = one.Make({tetrahedron});
    ASSERT_TRUE(made.has_value()) << made.error().message;
    counts.push_back(made->cloud.size());
  }
  EXPECT_GT(counts[0], 4 * counts[1]);
}

/// One grey, as a bitmap of 8 x 8.
std::string GreyBitmap(char grey) {
  std::string file = "BM";
  const auto put = [&file](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
      file.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
  };
  constexpr int kSide = 8, kStart = 54;
  put(kStart + kSide * kSide * 3, 4), put(0, 4), put(kStart, 4);
  put(40, 4), put(kSide, 4), put(kSide, 4), put(1, 2), put(24, 2);
  for (int i = 0; i < 6; ++i) put(0, 4);
  file.append(kSide * kSide * 3, grey);
  return file;
}

// The picture's grey is no matter to a curve that makes all brightness one.
TEST(ModelSources, APhotosToneFollowsItsCurve) {
  const auto count_of = [](char grey, double to) {
    OneModel one;
    one.model.set_file("photo.bmp");
    HalftoneMethod& halftone = *one.model.mutable_halftone();
    if (to >= 0) {
      for (const double from : {0.0, 1.0}) {
        TonePoint& point = *halftone.add_curve();
        point.set_from(from), point.set_to(to);
      }
    }
    const std::string file = GreyBitmap(grey);
    const auto made = one.Make({file});
    EXPECT_TRUE(made.has_value()) << made.error().message;
    return made ? made->cloud.size() : 0;
  };
  const std::size_t as_it_is = count_of('\x80', -1);
  EXPECT_GT(as_it_is, 1000u);
  EXPECT_EQ(count_of('\x10', 128 / 255.0), as_it_is);
  EXPECT_GT(count_of('\x10', 0.8), as_it_is * 2);
  EXPECT_EQ(count_of('\x80', 0), 0u);
}

// Which of the files belongs to which model does not depend on what they hold.
TEST(ModelSources, ACloudThatCouldHaveBeenAMeshTakesTheImageOfItsMethod) {
  OneModel one;
  one.model.set_file("scan.ply");
  one.model.mutable_even()->set_image("shade.bmp");
  one.job.add_models()->set_file("three.xyz");
  const std::string image = GreyBitmap('\x80');
  const auto made = one.Make(
      {"ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double "
       "y\nproperty double z\nend_header\n5 5 5\n9 5 5\n",
       image, "5 5 9\n6 5 9\n5 5 11\n"});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_EQ(made->cloud.size(), 5u);
}

TEST(ModelSources, AReliefHasItsLayersAboveOneAnother) {
  const auto made_of = [](std::uint32_t layers) {
    OneModel one;
    one.model.set_file("depth.bmp");
    ReliefMethod& relief = *one.model.mutable_relief();
    relief.set_layer_count(layers);
    relief.set_layer_distance_mm(2);
    const std::string file = GreyBitmap('\x80');
    return one.Make({file});
  };
  const auto one = made_of(1), three = made_of(3);
  ASSERT_TRUE(one && three);
  std::set<std::int64_t> depths_um;
  for (const Vec3& p : three->cloud.points_mm)
    depths_um.insert(std::llround(p.y() * 1e3));
  ASSERT_EQ(depths_um.size(), 3u);
  EXPECT_EQ(*depths_um.rbegin() - *depths_um.begin(), 4000);
  EXPECT_NEAR(
      static_cast<double>(three->cloud.size()) / static_cast<double>(one->cloud.size()),
      3, 0.1);
}

TEST(ModelSources, PointsByHandAreACloudWithoutAFile) {
  OneModel one;
  for (const Vec3& p : {Vec3(4, 5, 3), Vec3(7, 8, 6)}) {
    Vector3& point = *one.model.add_points_mm();
    point.set_x(p.x()), point.set_y(p.y()), point.set_z(p.z());
  }
  one.model.mutable_placement()->mutable_move_mm()->set_z(10);
  const auto made = one.Make({});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_EQ(made->cloud.points_mm, (PointList{{4, 5, 13}, {7, 8, 16}}));
  one.model.set_file("three.xyz");
  const auto found = CheckJob(one.job);
  EXPECT_TRUE(std::ranges::any_of(found, [](const Finding& f) {
    return f.message ==
           "models[0].points_mm: 2 points are given beside a file; make two models";
  }));
}

TEST(ModelSources, AModelOfALayerLiesInItsPlaceOfTheWholeDrawing) {
  // An outline of 20 x 10 mm in one group, a line of 4 mm in its corner in another.
  constexpr std::string_view kPlan =
      "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='10mm' "
      "viewBox='0 0 20 10'><g id='outline'><rect width='20' height='10'/></g>"
      "<g id='mark'><path d='M1 1H5'/></g></svg>";
  OneModel one;
  one.model.set_file("plan.svg");
  one.model.add_layers("mark");
  one.model.mutable_placement()->set_up(UP_AXIS_Z);
  one.model.mutable_curves()->set_distance_mm(1);
  const auto mark = one.Make({kPlan});
  ASSERT_TRUE(mark.has_value()) << mark.error().message;
  Box3 box;
  for (const Vec3& p : mark->cloud.points_mm) box.Extend(p);
  // The block is 50 x 50 x 30 mm; the drawing's centre, (10, 5), lies in its middle.
  EXPECT_TRUE(box.min_mm.isApprox(Vec3(25 + 1 - 10, 25 + 9 - 5, 15), 1e-6))
      << box.min_mm.transpose();
  EXPECT_TRUE(box.max_mm.isApprox(Vec3(25 + 5 - 10, 25 + 9 - 5, 15), 1e-6));

  // What is engraved has to fit, not what is left out: a block of 12 mm for 4 mm of 20.
  one.job.mutable_block()->mutable_size_mm()->set_x(12);
  one.model.mutable_placement()->mutable_move_mm()->set_x(6);
  const auto small = one.Make({kPlan});
  EXPECT_TRUE(small.has_value()) << (small ? "" : small.error().message);
  one.job.mutable_block()->mutable_size_mm()->set_x(50);

  one.model.add_layers("Mark");
  const auto unknown = one.Make({kPlan});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_THAT(unknown.error().message,
              HasSubstr("no curves on a layer \"Mark\"; its layers are \"mark\", "
                        "\"outline\""));
}

}  // namespace
}  // namespace intaglio
