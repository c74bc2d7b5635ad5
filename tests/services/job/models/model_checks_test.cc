// What a person is asked about a model before anything is made of it.

#include "services/job/models/model_checks.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "services/job/convert/job_defaults.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/unfitted_sizes.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/services/job/models/all_formats.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kUnturned = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1";

/// A cone of height 20 along the axis 0, 1 or 2, with its flat base at 0.
mesh::TriangleMesh ConeAlong(int axis) {
  constexpr std::uint32_t kSides = 24;
  mesh::TriangleMesh cone;
  const auto corner = [axis](double along_mm, double u_mm, double v_mm) {
    Vec3 p;
    p[axis] = along_mm;
    p[(axis + 1) % 3] = u_mm;
    p[(axis + 2) % 3] = v_mm;
    return p;
  };
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const double turn = 2 * std::numbers::pi * i / kSides;
    cone.vertices.push_back(corner(0, 8 * std::cos(turn), 8 * std::sin(turn)));
  }
  cone.vertices.push_back(corner(20, 0, 0));
  for (std::uint32_t i = 0; i < kSides; ++i) {
    cone.triangles.push_back({i, (i + 1) % kSides, kSides});
    if (i + 1 < kSides && i > 0) cone.triangles.push_back({0, i + 1, i});
  }
  return cone;
}

std::string StlOf(const mesh::TriangleMesh& mesh) {
  std::string text = "solid made\n";
  for (const mesh::Triangle& t : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const std::uint32_t i : t) {
      const Vec3& v = mesh.vertices[i];
      text += fmt::format("vertex {} {} {}\n", v.x(), v.y(), v.z());
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid made\n";
}

/// A job with one model in the block of the sample, 50 x 50 x 30 mm.
struct CheckedModel {
  JobSpec job = GoodJob();
  Model& model = (job.mutable_models(0)->Clear(), *job.mutable_models(0));
  Placement& placement = *model.mutable_placement();

  Result<JobSources> Make(const std::string& name, const std::string& text) {
    model.set_file(name);
    const auto bytes = std::as_bytes(std::span(text));
    return MakeSources(WithDefaults(job, GoodMachine()),
                       {FileBytes(bytes.begin(), bytes.end())}, AllFormats(), {});
  }
  Vec3 SizeOf(const std::string& name, const std::string& text) {
    const auto made = Make(name, text);
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->sources.front()->Bounds().size_mm() : Vec3(Vec3::Zero());
  }
  Warnings WarningsAbout(const std::string& name, const std::string& text) {
    const auto made = Make(name, text);
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->warnings : Warnings();
  }
};

auto IsWarning(WarningCode code, WarningWeight weight, const auto& text) {
  return AllOf(Field(&Warning::code, code), Field(&Warning::weight, weight),
               Field(&Warning::text, text));
}

TEST(ModelChecks, SeventyMetresAreRefusedBeforeAnythingIsMade) {
  mesh::TriangleMesh large = ConeAlong(2);
  for (Vec3& v : large.vertices) v *= 3500;
  const auto made = CheckedModel().Make("/data/cone.stl", StlOf(large));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(made.error().message,
              AllOf(StartsWith("/data/cone.stl: the model is 56 x 56 x 70 m, "),
                    HasSubstr("larger than the block of 50 x 50 x 30 mm"),
                    HasSubstr("--size 27")));
}

TEST(ModelChecks, AnInchFileIsAskedAboutWithTheFlagToGive) {
  mesh::TriangleMesh small = ConeAlong(2);
  for (Vec3& v : small.vertices) v /= 25.4;  // 20 mm are 0.787 inches
  CheckedModel one;
  const std::string file = StlOf(small);
  EXPECT_THAT(
      one.WarningsAbout("cone.stl", file),
      ElementsAre(IsWarning(WarningCode::kImplausibleSize, WarningWeight::kWarning,
                            AllOf(StartsWith("cone.stl: "),
                                  HasSubstr("in inches? Then give --unit 25.4")))));
  one.placement.set_unit_mm(25.4);
  EXPECT_THAT(one.WarningsAbout("cone.stl", file), IsEmpty());
  EXPECT_NEAR(one.SizeOf("cone.stl", file).z(), 20, 1e-4);
}

TEST(ModelChecks, ADrawingOfAnotherUnitIsAskedAboutAsWell) {
  CheckedModel one;
  const std::string line =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" )"
      R"(viewBox="0 0 90 90"><path d="M0 0L90 90"/></svg>)";
  const auto made = one.Make("line.svg", line);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("larger than the block"));
  one.placement.set_fit_block(true);
  EXPECT_TRUE(one.Make("line.svg", line));
}

TEST(ModelChecks, AHugePanelIsRefusedBeforeItIsSampled) {
  CheckedModel one;
  one.placement.set_unit_mm(1000);
  std::string bitmap = "BM";  // 8 x 8 pixels of 24 bits
  const auto add = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bitmap += static_cast<char>(value >> (8 * i));
  };
  add(54 + 192, 4), add(0, 4), add(54, 4), add(40, 4), add(8, 4), add(8, 4), add(1, 2);
  add(24, 2), add(0, 4), add(192, 4), add(0, 4), add(0, 4), add(0, 4), add(0, 4);
  bitmap += std::string(192, '\x80');
  const auto made = one.Make("photo.bmp", bitmap);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kOutsideBlock) << made.error().message;
  one.placement.clear_unit_mm();
  const Vec3 size_mm = one.SizeOf("photo.bmp", bitmap);
  EXPECT_LT(size_mm.y(), 1e-6) << "a photo is upright";
  EXPECT_GT(size_mm.z(), 20);
}

TEST(ModelChecks, AGltfIsUprightUnlessItIsRotatedAsItLies) {
  const std::string file = mesh::Gltf(ConeAlong(1), kUnturned);
  CheckedModel one;
  EXPECT_THAT(one.WarningsAbout("cone.gltf", file), IsEmpty());
  EXPECT_NEAR(one.SizeOf("cone.gltf", file).z(), 20, 1e-4);
  one.placement.mutable_rotate_deg()->set_z(45);
  EXPECT_THAT(one.WarningsAbout("cone.gltf", file),
              ElementsAre(IsWarning(WarningCode::kOrientation, WarningWeight::kNote,
                                    HasSubstr("add --up y (placement.up: UP_AXIS_Y)"))));
  one.placement.set_up(UP_AXIS_Y);
  EXPECT_THAT(one.WarningsAbout("cone.gltf", file), IsEmpty());
  // As it was turned before formats had an up axis.
  one.placement.clear_up();
  one.placement.mutable_rotate_deg()->set_z(0);
  one.placement.mutable_rotate_deg()->set_x(90);
  EXPECT_THAT(one.WarningsAbout("cone.gltf", file), IsEmpty());
  EXPECT_NEAR(one.SizeOf("cone.gltf", file).z(), 20, 1e-4);
}

TEST(ModelChecks, AColladaIsUprightAsItsFileDeclares) {
  const auto dae = [](const std::string& asset) {
    return mesh::Dae(ConeAlong(1), asset, "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
  };
  CheckedModel one;
  EXPECT_NEAR(one.SizeOf("t.dae", dae("<up_axis>Y_UP</up_axis>")).z(), 20, 1e-4);
  EXPECT_NEAR(one.SizeOf("t.dae", dae("")).z(), 20, 1e-4) << "the standard's default";
  EXPECT_NEAR(one.SizeOf("t.dae", dae("<up_axis>Z_UP</up_axis>")).y(), 20, 1e-4);
  // Right is -y.
  EXPECT_NEAR(one.SizeOf("t.dae", dae("<up_axis>X_UP</up_axis>")).x(), 20, 1e-4);
  one.placement.set_up(UP_AXIS_Z);
  EXPECT_NEAR(one.SizeOf("t.dae", dae("<up_axis>Y_UP</up_axis>")).y(), 20, 1e-4);
}

TEST(ModelChecks, AFigureOnItsHeadOrItsBackIsAskedAbout) {
  CheckedModel one;
  EXPECT_THAT(one.WarningsAbout("cone.stl", StlOf(ConeAlong(2))), IsEmpty());
  one.placement.set_up(UP_AXIS_MINUS_Z);
  EXPECT_THAT(
      one.WarningsAbout("cone.stl", StlOf(ConeAlong(2))),
      ElementsAre(IsWarning(WarningCode::kOrientation, WarningWeight::kNote,
                            AllOf(HasSubstr("upside down"),
                                  HasSubstr("--up z (placement.up: UP_AXIS_Z)")))));
  // An OBJ of most programs: y up, and nothing in the file says so.
  one.placement.clear_up();
  EXPECT_THAT(
      one.WarningsAbout("cone.stl", StlOf(ConeAlong(1))),
      ElementsAre(IsWarning(WarningCode::kOrientation, WarningWeight::kNote,
                            AllOf(HasSubstr("on its back"), HasSubstr("--up y")))));
  one.placement.set_up(UP_AXIS_Y);
  EXPECT_THAT(one.WarningsAbout("cone.stl", StlOf(ConeAlong(1))), IsEmpty());
}

/// A ball: no face of it tells where its base is.
mesh::TriangleMesh RoundMesh() {
  mesh::TriangleMesh ball;
  constexpr std::uint32_t kRings = 16, kSides = 32;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double turn = 2 * std::numbers::pi * i / kSides;
      ball.vertices.push_back(10 * Vec3(std::sin(polar) * std::cos(turn),
                                        std::sin(polar) * std::sin(turn),
                                        std::cos(polar)));
    }
  }
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = ring * kSides + i, b = ring * kSides + (i + 1) % kSides;
      ball.triangles.push_back({a, a + kSides, b});
      ball.triangles.push_back({b, a + kSides, b + kSides});
    }
  }
  return ball;
}

auto AsksForUp(WarningWeight weight, const char* text) {
  return ::testing::Contains(
      IsWarning(WarningCode::kOrientation, weight, HasSubstr(text)));
}

auto AsksNothingAboutUp() {
  return Not(::testing::Contains(Field(&Warning::code, WarningCode::kOrientation)));
}

TEST(ModelChecks, AFormatWithoutAnUpAxisIsAskedAboutUntilItIsAnswered) {
  const std::string obj = mesh::Obj(RoundMesh()), ply = mesh::Ply(RoundMesh());
  CheckedModel one;
  EXPECT_THAT(one.WarningsAbout("ball.obj", obj),
              AsksForUp(WarningWeight::kNote, "--accept up=y"));
  EXPECT_THAT(one.WarningsAbout("ball.OBJ", obj),
              AsksForUp(WarningWeight::kNote, "--accept up=z"));
  EXPECT_THAT(one.WarningsAbout("ball.ply", ply),
              AsksForUp(WarningWeight::kNote, "many of its files"));
  EXPECT_THAT(one.WarningsAbout("ball.stl", StlOf(RoundMesh())), AsksNothingAboutUp());
  for (const UpAxis answer : {UP_AXIS_Y, UP_AXIS_Z}) {
    one.placement.set_up(answer);
    EXPECT_THAT(one.WarningsAbout("ball.obj", obj), AsksNothingAboutUp());
    EXPECT_THAT(one.WarningsAbout("ball.ply", ply), AsksNothingAboutUp());
  }
}

TEST(ModelChecks, AFlatFaceSpeaksForOrAgainstTheConvention) {
  CheckedModel one;
  EXPECT_THAT(one.WarningsAbout("cone.obj", mesh::Obj(ConeAlong(1))),
              AsksForUp(WarningWeight::kWarning, "--up y"));
  EXPECT_THAT(one.WarningsAbout("cone.ply", mesh::Ply(ConeAlong(1))),
              AsksForUp(WarningWeight::kNote, "--up y"));
  EXPECT_THAT(one.WarningsAbout("cone.obj", mesh::Obj(ConeAlong(2))),
              AsksNothingAboutUp())
      << "it stands on its base";
}

TEST(ModelChecks, ADrawingThatIsRotatedAndLiesFlatIsAskedAbout) {
  const std::string square =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" )"
      R"(viewBox="0 0 20 20"><path d="M0 0L20 0L20 20L0 20Z"/></svg>)";
  CheckedModel one;
  EXPECT_NEAR(one.SizeOf("square.svg", square).z(), 20, 0.3) << "upright";
  one.placement.mutable_rotate_deg()->set_z(90);
  EXPECT_THAT(one.WarningsAbout("square.svg", square),
              ElementsAre(IsWarning(WarningCode::kOrientation, WarningWeight::kNote,
                                    HasSubstr("lies flat in the block"))));
  one.placement.mutable_rotate_deg()->set_z(0);
  one.placement.mutable_rotate_deg()->set_x(90);
  EXPECT_THAT(one.WarningsAbout("square.svg", square), IsEmpty());
  one.placement.clear_rotate_deg();
  one.placement.set_up(UP_AXIS_Z);
  EXPECT_THAT(one.WarningsAbout("square.svg", square), IsEmpty()) << "asked for";
  EXPECT_NEAR(one.SizeOf("square.svg", square).y(), 20, 0.3);
}

TEST(ModelChecks, SizesAreCheckedBeforeTheJobIsSubmitted) {
  JobSpec job = GoodJob();  // a knot, fitted to a height of 22 mm
  EXPECT_TRUE(CheckUnfittedSizes(WithDefaults(job, GoodMachine()), {}));
  Placement& placement = *job.mutable_models(0)->mutable_placement();
  placement.set_fit_height_mm(1000);
  EXPECT_TRUE(CheckUnfittedSizes(WithDefaults(job, GoodMachine()), {}))
      << "the size was asked for; the checks of the job refuse it";
  placement.clear_fit();
  placement.set_unit_mm(1000);
  // A grid of copies is not one large model.
  job.mutable_models(0)->mutable_copies()->set_count_x(3);
  const Status refused = CheckUnfittedSizes(WithDefaults(job, GoodMachine()), {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message, HasSubstr("sample.obj: the model is"));
  placement.set_unit_mm(1);
  job.mutable_models(0)->set_file("/nowhere/else.stl");
  EXPECT_TRUE(CheckUnfittedSizes(WithDefaults(job, GoodMachine()), {}))
      << "that it does not exist is reported by the checks of the job";
}

TEST(ModelChecks, SizesAreThoseOfTheFilesWithoutMakingPoints) {
  JobSpec job = GoodJob();  // a knot, fitted to a height of 22 mm
  const auto sizes = SizesOf(WithDefaults(job, GoodMachine()), {});
  ASSERT_TRUE(sizes) << sizes.error().message;
  ASSERT_EQ(sizes->size(), 1u);
  EXPECT_NEAR(sizes->front().size_mm.z(), 22, 1e-9);
}

}  // namespace
}  // namespace intaglio
