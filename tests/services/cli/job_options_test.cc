// Every flag of a job lands in its field, flags win over the job file, and what
// contradicts itself is refused with a sentence that names the flag.

#include "services/cli/job/job_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kModel = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.obj";
const std::string kJob = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto";

Status Parse(const std::vector<std::string>& words, JobFlags& flags) {
  command_line::Program program("intaglio", "");
  AddJobFlags(program.root(), flags);
  return program.Parse(words);
}

JobFlags Typed(const std::vector<std::string>& words) {
  JobFlags flags;
  EXPECT_TRUE(Parse(words, flags));
  return flags;
}

Result<JobAndMachine> Built(const std::vector<std::string>& words) {
  JobFlags flags;
  if (auto parsed = Parse(words, flags); !parsed) return tl::unexpected(parsed.error());
  return BuildJob(flags);
}

/// The job of the supplied model, 22 mm high, and these flags.
JobSpec JobOf(std::vector<std::string> more) {
  std::vector<std::string> words = {"--mesh", kModel, "--height", "22"};
  words.insert(words.end(), more.begin(), more.end());
  const auto built = Built(words);
  EXPECT_TRUE(built) << (built ? "" : built.error().message);
  return built ? built->job : JobSpec();
}

std::string RefusalOf(const std::vector<std::string>& words) {
  const auto built = Built(words);
  return built ? "" : built.error().message;
}

// Before a block is chosen for it: no scale of the model would help.
TEST(JobFlags, AMachineThatMarksIsRefusedForPointsAtOnce) {
  for (const char* machine : {"galvo", "mill", "laser-cutter", "bjjcz"}) {
    EXPECT_THAT(RefusalOf({kModel, "--height", "22", "--machine", machine}),
                HasSubstr("it makes marks or contours"))
        << machine;
    const auto points = BuildJobOfPoints(Typed({"--machine", machine}), {Vec3(1, 1, 1)});
    ASSERT_FALSE(points) << machine;
    EXPECT_THAT(points.error().message, HasSubstr("a machine that engraves"));
  }
}

// As `preview` takes them: what is named without an option is the job, or its models.
TEST(JobFlags, AJobFileOrModelsNeedNoOption) {
  EXPECT_EQ(Built({kModel, "--height", "22"})->job.SerializeAsString(),
            JobOf({}).SerializeAsString());
  EXPECT_EQ(Built({kModel, "--mesh", kModel, "--height", "9"})->job.models_size(), 2);
  EXPECT_EQ(Built({kJob})->job.SerializeAsString(),
            Built({"sample"})->job.SerializeAsString());
  EXPECT_THAT(RefusalOf({kModel, kJob}), HasSubstr("one job file, or models, not both"));
  EXPECT_THAT(RefusalOf({"nothing.obj"}), HasSubstr("nothing.obj"));
}

TEST(JobFlags, ASizeMayBeOneArgument) {
  EXPECT_EQ(JobOf({"--block", "60x55x50"}).SerializeAsString(),
            JobOf({"--block", "60", "55", "50"}).SerializeAsString());
}

double MoveOf(const JobSpec& job, int model, char axis) {
  const Vector3& move = job.models(model).placement().move_mm();
  return axis == 'x' ? move.x() : axis == 'y' ? move.y() : move.z();
}

// The sample is 22 mm high, capitals are 5 mm high; 2 mm lie between them, and both
// together are in the middle of the block.
TEST(Arrangement, ATextLiesBelowTheModelsUnlessItsPlaceIsGiven) {
  const std::vector<std::string> text = {"--text", "MIMI", "--height", "22"};
  const auto with = [&text](std::vector<std::string> words) {
    words.insert(words.begin(), kModel);
    words.insert(words.end(), text.begin(), text.end());
    const auto built = Built(words);
    EXPECT_TRUE(built) << (built ? "" : built.error().message);
    return built ? *built : JobAndMachine();
  };
  // --height is that of the models, not of the text beside them.
  const JobAndMachine below = with({});
  ASSERT_EQ(below.job.models_size(), 2);
  EXPECT_NEAR(MoveOf(below.job, 0, 'z') - MoveOf(below.job, 1, 'z'), 11 + 2 + 2.5, 0.1);
  EXPECT_NEAR(MoveOf(below.job, 0, 'z'), (2 + 5) / 2., 0.1)
      << "both together in the middle";
  EXPECT_NEAR(MoveOf(below.job, 0, 'x'), 0, 1e-6);
  EXPECT_GE(below.job.block().size_mm().z(), 22 + 2 + 5 + 10) << "it holds both";
  EXPECT_EQ(with({"--text-place", "below"}).job.SerializeAsString(),
            below.job.SerializeAsString());

  const JobSpec above = with({"--text-place", "above"}).job;
  EXPECT_NEAR(MoveOf(above, 1, 'z') - MoveOf(above, 0, 'z'), 15.5, 0.1);
  const JobSpec left = with({"--text-place", "left"}).job;
  EXPECT_LT(MoveOf(left, 1, 'x'), MoveOf(left, 0, 'x') - 10);
  EXPECT_NEAR(MoveOf(left, 1, 'z'), MoveOf(left, 0, 'z'), 1e-6);
  const JobSpec right = with({"--text-place", "right"}).job;
  EXPECT_NEAR(MoveOf(right, 1, 'x') - MoveOf(right, 0, 'x'),
              MoveOf(left, 0, 'x') - MoveOf(left, 1, 'x'), 1e-6);
  const JobSpec front = with({"--text-place", "front"}).job;
  EXPECT_LT(MoveOf(front, 1, 'y'), MoveOf(front, 0, 'y') - 2);
  const JobSpec behind = with({"--text-place", "behind"}).job;
  EXPECT_GT(MoveOf(behind, 1, 'y'), MoveOf(behind, 0, 'y') + 2);
}

TEST(Arrangement, ATextAmongTheModelsIsAWarningWithTheVolume) {
  const auto centre =
      Built({kModel, "--height", "22", "--text", "MIMI", "--text-place", "centre"});
  ASSERT_TRUE(centre) << centre.error().message;
  EXPECT_NEAR(MoveOf(centre->job, 1, 'z'), 0, 1e-6);
  EXPECT_THAT(
      centre->notes,
      ::testing::Contains(HasSubstr("the text and the models overlap in a volume")));
  ASSERT_EQ(centre->of_arrangement.size(), 1u);
  EXPECT_EQ(centre->of_arrangement[0].code, WarningCode::kModelsOverlap);
  const auto below = Built({kModel, "--height", "22", "--text", "MIMI"});
  EXPECT_THAT(below->notes, ::testing::Not(::testing::Contains(HasSubstr("overlap"))));
}

TEST(Arrangement, ModelsLieSideBySideUnlessTheyHaveAPlaceOfTheirOwn) {
  const JobSpec job = Built({kModel, kModel, kModel, "--height", "9"})->job;
  EXPECT_NEAR(MoveOf(job, 1, 'x'), 0, 1e-6);
  EXPECT_NEAR(MoveOf(job, 0, 'x'), -MoveOf(job, 2, 'x'), 1e-6);
  EXPECT_LT(MoveOf(job, 0, 'x'), -2);
  const JobSpec placed =
      Built({kModel, kModel, "--height", "9", "--set", "models[1].placement.move_mm.x=3"})
          ->job;
  EXPECT_EQ(MoveOf(placed, 0, 'x'), 0);
  EXPECT_EQ(MoveOf(placed, 1, 'x'), 3);
}

TEST(Arrangement, ThatCannotBeMadeIsRefused) {
  EXPECT_THAT(RefusalOf({kModel, "--text-place", "below"}),
              HasSubstr("--text-place: the job has no text"));
  EXPECT_THAT(RefusalOf({kModel, "--text", "A", "--text-place", "under"}),
              HasSubstr("below"));
}

TEST(JobFlags, OfTheModelLandInItsPlacement) {
  const JobSpec job = JobOf({"--rotate", "90", "-45", "10", "--unit", "25.4"});
  ASSERT_EQ(job.models_size(), 1);
  EXPECT_EQ(job.models(0).file(), kModel);
  const Placement& placement = job.models(0).placement();
  EXPECT_EQ(placement.fit_height_mm(), 22);
  EXPECT_EQ(placement.unit_mm(), 25.4);
  EXPECT_EQ(placement.rotate_deg().x(), 90);
  EXPECT_EQ(placement.rotate_deg().y(), -45);
  EXPECT_EQ(placement.rotate_deg().z(), 10);
  const auto sized = Built({"--mesh", kModel, "--size", "31"});
  ASSERT_TRUE(sized) << sized.error().message;
  EXPECT_EQ(sized->job.models(0).placement().fit_size_mm(), 31);
  EXPECT_FALSE(sized->job.models(0).placement().has_fit_height_mm());
}

TEST(JobFlags, OfTheBlockAndTheGlassLandInThem) {
  const JobSpec job =
      JobOf({"--block", "60", "55", "50", "--margin", "4", "--clip", "--glass",
             "fused-silica", "--focal", "70", "--name", "a knot"});
  EXPECT_EQ(job.block().size_mm().x(), 60);
  EXPECT_EQ(job.block().size_mm().y(), 55);
  EXPECT_EQ(job.block().size_mm().z(), 50);
  EXPECT_EQ(job.block().margin_mm(), 4);
  EXPECT_TRUE(job.block().clip());
  EXPECT_EQ(job.glass(), "fused-silica");
  EXPECT_EQ(job.lens().focal_length_mm(), 70);
  EXPECT_EQ(job.lens().numerical_aperture(), 5.0 / 140) << "of the machine's lens";
  EXPECT_EQ(job.name(), "a knot");
}

TEST(JobFlags, OfTheMethodLandInIt) {
  const JobSpec sections = JobOf(
      {"--method", "sections", "--layer", "0.4", "--vertex", "0.35", "--spacing", "0.3"});
  ASSERT_TRUE(sections.discretization().has_sections());
  EXPECT_EQ(sections.discretization().sections().layer_distance_mm(), 0.4);
  EXPECT_EQ(sections.discretization().sections().vertex_distance_mm(), 0.35);
  EXPECT_EQ(sections.discretization().min_spacing_mm(), 0.3);
  const JobSpec even = JobOf({"--vertex", "0.35", "--spacing", "0.3"});
  ASSERT_TRUE(even.discretization().has_even()) << "the default";
  EXPECT_EQ(even.discretization().even().distance_mm(), 0.35);
  const JobSpec fill = JobOf({"--method", "fill", "--vertex", "0.5"});
  ASSERT_TRUE(fill.discretization().has_fill());
  EXPECT_EQ(fill.discretization().fill().vertex_distance_mm(), 0.5);
  const JobSpec rays = JobOf({"--method", "rays", "--vertex", "0.6"});
  ASSERT_TRUE(rays.discretization().has_rays());
  EXPECT_EQ(rays.discretization().rays().distance_mm(), 0.6);
}

TEST(JobFlags, OfOrderMotionAndLaserLandInThem) {
  const JobSpec job = JobOf({"--order", "layers", "--profile", "cubic", "--rate", "25",
                             "--speed-limit", "30", "--acceleration", "900"});
  EXPECT_TRUE(job.ordering().has_layers());
  EXPECT_EQ(job.motion().profile(), MOTION_PROFILE_CUBIC);
  EXPECT_EQ(job.motion().max_speed_mm_s(), 30);
  EXPECT_EQ(job.motion().max_acceleration_mm_s2(), 900);
  EXPECT_EQ(job.laser().rate_hz(), 25);
  EXPECT_EQ(JobOf({"--profile", "time-optimal"}).motion().profile(),
            MOTION_PROFILE_TIME_OPTIMAL);
  EXPECT_EQ(JobOf({"--profile", "lq"}).motion().profile(), MOTION_PROFILE_LQ);
  EXPECT_TRUE(JobOf({"--order", "kdz"}).ordering().has_kdz());
  EXPECT_TRUE(JobOf({"--order", "published-kdz"}).ordering().has_published_kdz());
  EXPECT_EQ(JobOf({"--order-tries", "200"}).ordering().anneal().tries_per_point(), 200);
  EXPECT_EQ(JobOf({"--order-pieces", "50"}).ordering().anneal().pieces(), 50u);
  EXPECT_EQ(JobOf({"--order-time", "9"}).ordering().anneal().time_s(), 9);
}

// A row of a batch, or a piece of a series: fields of points would refuse it.
TEST(CompletedJob, OfMarksHasNoFieldOfPoints) {
  const auto read =
      ReadPattern(Typed({INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto"}));
  ASSERT_TRUE(read) << read.error().message;
  const auto completed = CompleteJob(JobFlags(), *read);
  ASSERT_TRUE(completed) << completed.error().message;
  EXPECT_FALSE(completed->job.has_ordering());
  EXPECT_FALSE(completed->job.has_discretization());
}

// Who makes points of a job of marks is told what it is, not which fields it lacks.
TEST(JobOfMarks, IsRefusedByItsKindWherePointsAreMade) {
  const std::string label = INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto";
  const std::string refusal = RefusalOf({label});
  EXPECT_THAT(refusal, HasSubstr("intaglio marks preview JOB"));
  EXPECT_THAT(refusal, Not(HasSubstr("discretization")));
  const auto built = BuildJobOfAnyKind(Typed({label}));
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_TRUE(built->job.has_marks());
  EXPECT_FALSE(built->job.has_discretization());
}

TEST(JobOfMarks, HasTheFieldsThatAreSet) {
  const auto built =
      BuildJobOfAnyKind(Typed({INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto",
                               "--set", "marks.pen.speed_mm_s=700"}));
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->job.marks().pen().speed_mm_s(), 700);
  const auto refused =
      BuildJobOfAnyKind(Typed({INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto",
                               "--set", "marks.pen.speed_mm=700"}));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("--set: "));
}

TEST(JobFlags, OfTheMachineAreANameOrAFile) {
  const fs::path own = test::FreshFolder() / "own.textproto";
  std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  text.replace(text.find("\"els-03\""), 8, "\"mine\"");
  std::ofstream(own) << text;
  const auto built =
      Built({"--mesh", kModel, "--height", "22", "--machine", own.string()});
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->machine.name(), "mine");
  EXPECT_EQ(built->job.machine_file(), own);
  EXPECT_THAT(RefusalOf({"--mesh", kModel, "--machine", "els-30"}),
              ::testing::AllOf(HasSubstr("--machine: 'els-30'"), HasSubstr("els-03")));
}

TEST(JobFlags, AJobFileMayNameASuppliedMachine) {
  const fs::path folder = test::FreshFolder();
  const fs::path file = folder / "job.textproto";
  std::ifstream in(kJob);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  text.replace(text.find("sample.obj"), 10, kModel);
  text.replace(text.find("../machines/els-03.textproto"), 28, "els-03");
  std::ofstream(file) << text;
  const auto supplied = Built({file.string()});
  ASSERT_TRUE(supplied) << supplied.error().message;
  EXPECT_EQ(supplied->machine.name(), "els-03");
  EXPECT_TRUE(fs::path(supplied->job.machine_file()).is_absolute());
  // A file of that name beside the job file comes first.
  fs::create_directory(folder / "els-03");
  EXPECT_THAT(RefusalOf({file.string()}), HasSubstr((folder / "els-03").string()));
}

TEST(JobFlags, WinOverTheJobFileAndLeaveTheRestOfIt) {
  const auto built =
      Built({kJob, "--size", "12", "--spacing", "0.5", "--glass", "soda-lime"});
  ASSERT_TRUE(built) << built.error().message;
  const JobSpec& job = built->job;
  EXPECT_EQ(job.models(0).placement().fit_size_mm(), 12) << "replaces the file's height";
  EXPECT_EQ(job.discretization().min_spacing_mm(), 0.5);
  EXPECT_EQ(job.glass(), "soda-lime");
  EXPECT_EQ(job.name(), "trefoil knot");
  EXPECT_EQ(job.block().size_mm().z(), 30);
}

TEST(JobFlags, WithoutABlockOneIsChosenAroundTheObject) {
  const auto built = Built({"--mesh", kModel, "--height", "22"});
  ASSERT_TRUE(built);
  // 22 mm high and 5 mm of glass on both sides, in steps of 5 mm.
  EXPECT_EQ(built->job.block().size_mm().z(), 35);
  ASSERT_EQ(built->notes.size(), 1u);
  EXPECT_THAT(built->notes[0], HasSubstr("--block X Y Z"));
}

TEST(JobFlags, ThatContradictEachOtherAreRefused) {
  JobFlags flags;
  EXPECT_FALSE(Parse({"--mesh", kModel, "--height", "1", "--size", "2"}, flags));
  EXPECT_FALSE(Parse({"--mesh", kModel, "--rotate", "1", "2"}, flags));
  EXPECT_FALSE(Parse({"--mesh", kModel, "--block", "1"}, flags));
  EXPECT_FALSE(Parse({"--mesh", kModel, "--height", "tall"}, flags));
  for (const char* method : {"fill", "rays"}) {
    EXPECT_THAT(
        RefusalOf(
            {"--mesh", kModel, "--height", "22", "--method", method, "--layer", "0.1"}),
        ::testing::AllOf(HasSubstr("--layer"), HasSubstr("sections"), HasSubstr(method)));
  }
}

TEST(JobFlags, WithUnknownNamesAreAnsweredWithTheKnownOnes) {
  const auto refusal = [](const char* flag, const char* name) {
    return RefusalOf({"--mesh", kModel, "--height", "22", flag, name});
  };
  EXPECT_THAT(refusal("--method", "section"),
              ::testing::AllOf(HasSubstr("sections, fill, rays, even, solid"),
                               HasSubstr("did you mean sections?")));
  EXPECT_THAT(refusal("--order", "zigzag"), HasSubstr("kdz, layers, smooth, anneal"));
  EXPECT_THAT(refusal("--order-tries", "-1"), HasSubstr("tries_per_point"));
  EXPECT_THAT(refusal("--profile", "s-curve"),
              HasSubstr("continuous, triangle, trapezoid, cubic, mix, time-optimal, "
                        "interpolator, parabola, lq"));
  EXPECT_THAT(refusal("--rate", "77"), HasSubstr("laser.rate_hz"));
}

// What the points were made from may be gone by then.
TEST(JobOfPoints, IsCheckedWithoutItsModels) {
  const fs::path file = test::FreshFolder() / "job.textproto";
  std::ifstream in(kJob);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  text.replace(text.find("sample.obj"), 10, "gone.obj");
  text.replace(text.find("../machines"), 11, INTAGLIO_SOURCE_DIR "/deploy/machines");
  std::ofstream(file) << text;
  EXPECT_THAT(RefusalOf({file.string()}), HasSubstr("gone.obj does not exist"));
  const auto built = BuildJobOfPoints(Typed({file.string()}), {});
  EXPECT_TRUE(built) << built.error().message;
  const auto refused = BuildJobOfPoints(Typed({file.string(), "--rate", "77"}), {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("laser.rate_hz"));
}

TEST(JobFlags, WithoutAnythingToEngraveNameTheRemedy) {
  EXPECT_THAT(RefusalOf({}), HasSubstr("name a job file, a model"));
  EXPECT_THAT(RefusalOf({"nowhere.textproto"}), HasSubstr("nowhere.textproto"));
}

}  // namespace
}  // namespace intaglio::cli
