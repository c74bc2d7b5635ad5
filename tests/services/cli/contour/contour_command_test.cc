// `intaglio contour`, and `intaglio post` of a job with contours, from files to files.

#include "services/cli/contour/contour_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>
#include <set>

#include "engrave/contour/files/project_file.h"
#include "services/cli/contour/contour_figures.h"
#include "services/cli/contour/contour_files.h"
#include "services/cli/contour/contour_programs.h"
#include "services/cli/job/job_options.h"
#include "services/cli/offline/post_command.h"
#include "services/client/exit_codes.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/course/course_work.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// Two pads of 1 mm that a track of 0.4 joins, and a third pad 0.3 mm from it.
constexpr const char* kGerber =
    "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,1*%\n%ADD11C,0.4*%\n"
    "%TO.N,GND*%\nD10*\nX0Y0D03*\nX5000000Y0D03*\n"
    "D11*\nX0Y0D02*\nX5000000Y0D01*\n"
    "%TO.N,VCC*%\nD10*\nX2500000Y1000000D03*\nM02*\n";
constexpr const char* kExcellon =
    "M48\nMETRIC,TZ\nT1C0.600\nT2C0.400\n%\nT1\nX0.0Y0.0\nX5.0Y0.0\nT2\nX2.5Y1.0\nM30\n";

class ContourCommand : public TypedCommand {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    const fs::path file = folder_ / name;
    std::ofstream(file) << text;
    return file;
  }

  int Type(const std::vector<std::string>& words) {
    return TypeTo(
        [](command_line::Command root) {
          AddContourCommand(root);
          AddPostCommand(root);
        },
        words);
  }

  std::string Mill(const std::string& name) const {
    return INTAGLIO_SOURCE_DIR "/deploy/post/mill/" + name + ".post";
  }
  std::string Drill(const std::string& name) const {
    return INTAGLIO_SOURCE_DIR "/deploy/post/drill/" + name + ".post";
  }

  std::string gerber_ = Write("board.gbr", kGerber);
  std::string excellon_ = Write("board.drl", kExcellon);
};

// The contours beside the copper are those of a round tool of the width at that depth: a
// tip of 0.1 mm and 60 degrees are 0.1 + 2 x 0.2 tan(30 deg) = 0.330940 mm wide.
TEST_F(ContourCommand, AVShapedToolIsAsWideAsItsDepthMakesIt) {
  const std::string by_angle = folder_ / "v.svg", by_width = folder_ / "round.svg";
  ASSERT_EQ(Type({"contour", gerber_, "--make", "outline", "--depth", "0.2", "--tip",
                  "0.1", "--tool-angle", "60", "--template", Mill("linuxcnc"), "--out",
                  folder_ / "v.ngc", "--picture", by_angle}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("tool          0.3309 mm wide at 0.2 mm depth, 0.3887 "
                                 "mm where it is 0.05 mm deeper"));
  ASSERT_EQ(Type({"contour", gerber_, "--make", "outline", "--depth", "0.2", "--tool",
                  "0.33094010767585", "--picture", by_width}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, Not(HasSubstr("mm wide at")));
  const auto without_sign_of_zero = [](const std::string& file) {
    return std::regex_replace(test::ContentOf(file), std::regex("-0\\.000000"),
                              "0.000000");
  };
  EXPECT_EQ(without_sign_of_zero(by_angle), without_sign_of_zero(by_width));
  EXPECT_EQ(Type({"contour", gerber_, "--tip", "0.1"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("course.tool_angle_deg: is missing; give it, since"));
  EXPECT_EQ(Type({"contour", gerber_, "--tip", "0.1", "--tool-angle", "60", "--tool",
                  "0.5", "--depth", "0.2"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("course.tool_diameter_mm: 0.5 is not what a tip of 0.1 "
                                 "mm and 60 degrees cut at 0.2 mm, 0.3309; remove it"));
}

// The probing program covers contours and holes; what a probe logs at its places moves
// every depth of the next program.
TEST_F(ContourCommand, FollowsASurfaceThatItsOwnProgramProbes) {
  const std::string out = folder_ / "board.ngc", heights = folder_ / "heights.txt";
  std::vector<std::string> words = {
      "contour",          gerber_,           excellon_, "--template", Mill("linuxcnc"),
      "--drill-template", Drill("linuxcnc"), "--out",   out};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = words;
    all.insert(all.end(), more.begin(), more.end());
    return Type(all);
  };
  ASSERT_EQ(with({"--probe-grid", "4"}), client::kExitGood) << errors_;
  EXPECT_THAT(output_, HasSubstr("board_probe.ngc"));
  const std::string probing = test::ContentOf(folder_ / "board_probe.ngc");
  EXPECT_THAT(probing, HasSubstr("(PROBEOPEN board_probe.txt)"));
  static const std::regex kPlace("G0 X(\\S+) Y(\\S+)\nG38.2 Z-2 F60\n");
  std::ofstream log(heights);
  std::size_t places = 0;
  for (std::sregex_iterator at(probing.begin(), probing.end(), kPlace), end; at != end;
       ++at, ++places)
    log << (*at)[1] << " " << (*at)[2] << " 0.25 0 0 0 0 0 0\n";
  log.close();
  EXPECT_EQ(places, 6u) << "3 x 2 over 6.2 x 2.2 mm";
  ASSERT_EQ(with({"--height-map", heights}), client::kExitGood) << errors_;
  EXPECT_THAT(output_, HasSubstr("surface       3 x 2 heights, 0.250 to 0.250 mm"));
  const std::string program = test::ContentOf(out);
  EXPECT_THAT(program, HasSubstr("\nG0 Z2.2500\n"));
  EXPECT_THAT(program, HasSubstr(" Z0.0500\n")) << "0.2 mm below it";
  EXPECT_THAT(program, Not(HasSubstr("Z-0.2")));
  EXPECT_THAT(test::ContentOf(folder_ / "board_drill.ngc"),
              HasSubstr(" Z-2.7500 R2.2500"));
  EXPECT_EQ(with({"--height-map", heights, "--origin", "100", "0"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("probe the whole work, or check --origin"));
}

TEST_F(ContourCommand, AddsHolesForPinsOnTheLineOfTurning) {
  const std::string out = folder_ / "board.ngc";
  ASSERT_EQ(Type({"contour", gerber_, excellon_, "--mirror-x", "2.5", "--align", "-3",
                  "4", "--align-diameter", "2", "--template", Mill("linuxcnc"),
                  "--drill-template", Drill("linuxcnc"), "--out", out}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("elements      4, 5 holes with 3 tools"));
  EXPECT_THAT(errors_, HasSubstr("alignment holes of 2 mm at (2.5, -3) and (2.5, 4) mm"));
}

TEST_F(ContourCommand, IsolatesABoardAndDrillsIt) {
  const std::string out = folder_ / "board.ngc", picture = folder_ / "board.svg";
  ASSERT_EQ(Type({"contour", gerber_, excellon_, "--tool", "0.1", "--passes", "2",
                  "--template", Mill("linuxcnc"), "--drill-template", Drill("linuxcnc"),
                  "--out", out, "--picture", picture}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("elements      4, 3 holes with 2 tools"));
  EXPECT_THAT(output_, HasSubstr("isolation     2 nets, 0.15 mm around the copper"));
  EXPECT_THAT(output_, HasSubstr("contours      4,"));
  const std::string program = test::ContentOf(out);
  EXPECT_THAT(program, HasSubstr("(board)\nG21 G90"));
  const std::string holes = test::ContentOf(folder_ / "board_drill.ngc");
  // The thinner drill first.
  EXPECT_LT(holes.find("X2.50000 Y1.00000"), holes.find("X0.00000 Y0.00000"));
  EXPECT_THAT(holes, HasSubstr("(board_drill)"));
  EXPECT_THAT(holes, HasSubstr("Z-3.0000"));
  EXPECT_THAT(errors_, Not(HasSubstr("the depth of the holes")));
}

// The published short form drills DEEP - ABOVE = 2 mm, whatever the course has.
TEST_F(ContourCommand, ATemplateThatHasTheDepthOfHolesItselfIsNamed) {
  ASSERT_EQ(
      Type({"contour", gerber_, excellon_, "--tool", "0.1", "--template", Mill("krl"),
            "--drill-template", Drill("krl"), "--out", folder_ / "board.src"}),
      client::kExitGood)
      << errors_;
  EXPECT_THAT(errors_, HasSubstr("krl.post: has the depth of the holes itself, by its "
                                 "parameters or its text; the time is that of holes of "
                                 "3 mm (drill_depth_mm)"));
}

// A robot of another shop: its base, and where it comes from, in both programs.
TEST_F(ContourCommand, ParametersOfARobotAreInItsPrograms) {
  const std::string out = folder_ / "board.src";
  const std::vector<std::string> words = {
      "contour",    gerber_,          excellon_,          "--tool",          "0.1",
      "--template", Mill("krl-full"), "--drill-template", Drill("krl-full"), "--out",
      out,          "--parameter"};
  const auto with = [&](const std::string& parameter) {
    auto all = words;
    all.push_back(parameter);
    return Type(all);
  };
  ASSERT_EQ(with("BASE_DATA=4"), client::kExitGood) << errors_;
  for (const char* name : {"board.src", "board_drill.src"}) {
    const std::string program = test::ContentOf(folder_ / name);
    EXPECT_THAT(program, HasSubstr("Tool[8] Base[4]")) << name;
    EXPECT_THAT(program, testing::Not(HasSubstr("Base[31]"))) << name;
  }
  ASSERT_EQ(with("APPROACH=X 10, Y 20, Z 30"), client::kExitGood) << errors_;
  EXPECT_THAT(test::ContentOf(out), HasSubstr("FLin( { X 10, Y 20, Z 30 } )"));
  EXPECT_EQ(with("BASE=4"), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("they have TOOL_DATA, BASE_DATA"));
  EXPECT_EQ(with("BASE_DATA"), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is not NAME=TEXT"));
}

// Everything is known of a circle of 2 mm alone.
TEST_F(ContourCommand, FiguresAreThoseOfTheGeometry) {
  const std::string circle = Write(
      "circle.gbr", "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,2*%\nD10*\nX3000000Y0D03*\nM02*\n");
  Course course;
  course.add_files(circle);
  course.set_tool_diameter_mm(0.5);
  course.set_pass_count(2);
  course.set_speed_mm_s(10);
  course.set_repeat_count(3);
  course.set_depth_mm(0.3);
  const Course whole = WithDefaults(course);
  Warnings warnings;
  const auto files = ReadCourseFiles(whole, 1, warnings);
  ASSERT_TRUE(files) << files.error().message;
  const auto work = MakeContourWork(whole, *files, {0, 0});
  ASSERT_TRUE(work) << work.error().message;
  // Radii 1.25 and 1.5.
  EXPECT_NEAR(work->work_mm, 2 * std::numbers::pi * (1.25 + 1.5), 1e-9);
  EXPECT_NEAR(work->isolated_mm, 0.75, 1e-12);
  const WorkTime time = TimeOf(*work, whole);
  EXPECT_NEAR(time.work_s, 3 * work->work_mm / 10, 1e-9);
  // Each of two contours three times: 2 mm up at 50 mm/s, 2.3 mm down at 10.
  EXPECT_NEAR(time.idle_s, work->idle_mm / 50 + 6 * (2.0 / 50 + 2.3 / 10), 1e-9);
  const post::Cutting cutting = MillingOf(whole, course);
  EXPECT_THAT(cutting.depths_mm, testing::ElementsAre(testing::DoubleNear(-0.1, 1e-12),
                                                      testing::DoubleNear(-0.2, 1e-12),
                                                      testing::DoubleNear(-0.3, 1e-12)));
  EXPECT_THAT(cutting.given, testing::ElementsAre("SPEED", "DEPTH"));
}

// A bar that stands still, or runs backwards, reports nothing; what it ends has no
// result.
TEST_F(ContourCommand, ItsWorkReportsItsProgressAndEndsByIt) {
  Course course;
  course.add_files(gerber_);
  course.set_tool_diameter_mm(0.2);
  course.set_pass_count(2);
  Warnings warnings;
  const auto files = ReadCourseFiles(WithDefaults(course), 1, warnings);
  ASSERT_TRUE(files) << files.error().message;
  for (const CourseMake make : {COURSE_MAKE_ISOLATION, COURSE_MAKE_OUTLINE}) {
    course.set_make(make);
    std::vector<double> contours, order;
    const auto into = [](std::vector<double>& shares) {
      return [&shares](std::uint64_t done, std::uint64_t total) {
        shares.push_back(static_cast<double>(done) / static_cast<double>(total));
        return true;
      };
    };
    const CourseProgress progress{into(contours), into(order)};
    const auto work = MakeContourWork(WithDefaults(course), *files, {0, 0}, progress);
    ASSERT_TRUE(work) << work.error().message;
    for (const std::vector<double>* shares : {&contours, &order}) {
      ASSERT_GE(shares->size(), 3U);
      EXPECT_TRUE(std::ranges::is_sorted(*shares));
      EXPECT_NEAR(shares->front(), 0, 1e-9);
      EXPECT_NEAR(shares->back(), 1, 1e-9);
    }
    const ProgressSink end = [](std::uint64_t, std::uint64_t) { return false; };
    for (const CourseProgress& ended :
         {CourseProgress{end, {}}, CourseProgress{{}, end}}) {
      const auto none = MakeContourWork(WithDefaults(course), *files, {0, 0}, ended);
      ASSERT_FALSE(none);
      EXPECT_EQ(none.error().code, ErrorCode::kCancelled);
    }
  }
}

TEST_F(ContourCommand, ATooLargeToolIsRefusedByTheNetsNames) {
  const std::string out = folder_ / "board.ngc";
  EXPECT_EQ(Type({"contour", gerber_, "--tool", "0.5", "--template", Mill("linuxcnc"),
                  "--out", out}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("cannot isolate GND from VCC: gap 0.3 < tool 0.5"));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(ContourCommand, APictureIsADrawingOfTheContours) {
  const std::string picture = folder_ / "board.svg";
  ASSERT_EQ(Type({"contour", gerber_, "--tool", "0.1", "--picture", picture}),
            client::kExitGood)
      << errors_;
  const std::string first = output_;
  // Copper, idle ways and contours are its curves; the contours have their length.
  Course course;
  course.add_files(picture);
  course.set_make(COURSE_MAKE_CURVES);
  Warnings warnings;
  const auto files = ReadCourseFiles(course, 1, warnings);
  ASSERT_TRUE(files) << files.error().message;
  double longest_mm = 0;
  for (const DrawnCurve& curve : files->curves)
    longest_mm = std::max(longest_mm, contour::LengthOf(curve.edges));
  // Two pads of 1.1 mm that a track of 0.5 joins: arcs but where the track leaves.
  const double half = std::asin(0.25 / 0.55);
  const double expected_mm =
      2 * (2 * std::numbers::pi - 2 * half) * 0.55 + 2 * (5 - 2 * 0.55 * std::cos(half));
  EXPECT_NEAR(longest_mm, expected_mm, 0.002);
}

TEST_F(ContourCommand, AProjectComesBackAsItWas) {
  const fs::path source =
      fs::path(INTAGLIO_SOURCE_DIR) / "tests/data/contours/project_two_pads.xml";
  const std::string xml = folder_ / "copy.xml", again = folder_ / "again.xml";
  ASSERT_EQ(Type({"contour", source, "--xml", xml}), client::kExitGood) << errors_;
  ASSERT_EQ(Type({"contour", xml, "--xml", again}), client::kExitGood) << errors_;
  EXPECT_EQ(test::ContentOf(xml), test::ContentOf(again));
  const auto board =
      contour::BoardOf(contour::ReadProject(test::ContentOf(xml), "copy.xml").value());
  const auto original = contour::BoardOf(
      contour::ReadProject(test::ContentOf(source), "two_pads.xml").value());
  ASSERT_EQ(board.elements.size(), original.elements.size());
  for (std::size_t i = 0; i < board.elements.size(); ++i) {
    EXPECT_EQ(contour::Describe(board.elements[i]),
              contour::Describe(original.elements[i]));
  }
  EXPECT_EQ(board.holes.size(), original.holes.size());
  const std::string plate =
      Write("plate.svg",
            R"(<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="30mm" )"
            R"(viewBox="0 0 30 30"><rect x="5" y="5" width="20" height="20"/></svg>)");
  EXPECT_EQ(Type({"contour", plate, "--xml", xml}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("plate.svg, contour 1"));
}

TEST_F(ContourCommand, APlateIsCutAroundItselfAndInItsHole) {
  const std::string plate =
      Write("plate.svg",
            R"(<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="30mm" )"
            R"(viewBox="0 0 30 30"><rect x="5" y="5" width="20" height="20"/>)"
            R"(<rect x="10" y="10" width="10" height="10"/></svg>)");
  Course course;
  course.add_files(plate);
  course.set_make(COURSE_MAKE_OUTLINE);
  course.set_tool_diameter_mm(2);
  course.set_round_corners(true);
  const Course whole = WithDefaults(course);
  Warnings warnings;
  const auto files = ReadCourseFiles(whole, 1, warnings);
  ASSERT_TRUE(files);
  const auto work = MakeContourWork(whole, *files, {0, 0});
  ASSERT_TRUE(work) << work.error().message;
  ASSERT_EQ(work->paths.size(), 2U);
  // Around: four sides and a circle of radius 1; the hole: a square of 8.
  EXPECT_NEAR(work->work_mm, 80 + 2 * std::numbers::pi + 32, 1e-6);
}

TEST_F(ContourCommand, OpenCurvesHaveNoOutlineButCanBeFollowed) {
  const std::string line = Write(
      "line.svg", R"(<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="30mm" )"
                  R"(viewBox="0 0 30 30"><line x1="5" y1="5" x2="25" y2="5"/></svg>)");
  EXPECT_EQ(Type({"contour", line, "--make", "outline"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("line.svg: a contour is open at (25, 25); close it, or "
                                 "follow its curves with --make curves"));
  const std::string out = folder_ / "line.nc";
  ASSERT_EQ(Type({"contour", line, "--make", "curves", "--power", "0.4", "--speed", "20",
                  "--template", Mill("grbl-laser"), "--out", out}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(
      test::ContentOf(out),
      HasSubstr("G0 X5.0000 Y25.0000 S0\nG1 F1200.0 S400\nG1 X25.0000 Y25.0000\n"));
  EXPECT_EQ(Type({"contour", line, "--make", "curves", "--power", "0.4", "--template",
                  Mill("linuxcnc"), "--out", out}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("no fragment uses @POWER@"));
}

TEST_F(ContourCommand, TheToolIsThatOfTheTemplate) {
  const std::string mill =
      Write("own.post",
            "#tool-radius 0.05\n#extension txt\n#number DIAMETER decimals=3\n"
            "#fragment start\ntool @DIAMETER@\n#fragment approach\n@X@ @Y@\n"
            "#fragment line\n@X@ @Y@\n#fragment retract\nup\n");
  const std::string out = folder_ / "board.txt";
  ASSERT_EQ(Type({"contour", gerber_, "--template", mill, "--out", out}),
            client::kExitGood)
      << errors_;
  EXPECT_TRUE(test::ContentOf(out).starts_with("tool 0.100\n"));
  EXPECT_THAT(output_, HasSubstr("2 nets, 0.1 mm around the copper"));
  // What is typed counts: the gap is too narrow for it.
  EXPECT_EQ(Type({"contour", gerber_, "--template", mill, "--tool", "0.31"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("gap 0.3 < tool 0.31"));
}

TEST_F(ContourCommand, ErrorsNameFileAndRemedy) {
  const std::string odd = Write("board.txt", "nothing of the kind\n");
  EXPECT_EQ(Type({"contour", odd}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("board.txt: is neither a drawing"));
  EXPECT_EQ(Type({"contour", folder_ / "absent.gbr"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("absent.gbr does not exist or is not a file"));
  EXPECT_EQ(Type({"contour", gerber_, "--make", "outline", "--passes", "2"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is of isolations"));
  EXPECT_EQ(Type({"contour", excellon_, "--template", Mill("hpgl"), "--out",
                  folder_ / "a.plt"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--drill-template: is missing"));
}

TEST_F(ContourCommand, AJobOfContoursIsAProgram) {
  const std::string job =
      Write("board.textproto",
            "name: \"board\"\ncourse {\n  files: \"board.gbr\"\n  tool_diameter_mm: 0.1\n"
            "  speed_mm_s: 8\n  depth_mm: 0.4\n  repeat_count: 2\n}\n");
  const std::string out = folder_ / "board.src";
  ASSERT_EQ(Type({"post", job, "--template", Mill("krl-full"), "--out", out}),
            client::kExitGood)
      << errors_;
  const std::string program = test::ContentOf(out);
  EXPECT_THAT(program, HasSubstr("DEF board( )"));
  EXPECT_THAT(program, HasSubstr("Z -0.2 }"));
  EXPECT_THAT(program, HasSubstr("Z -0.4 }"));
  EXPECT_THAT(program, HasSubstr("Vel=0.008 m/s"));
  // The figures and the animation of a job, changed by what is given beside it.
  ASSERT_EQ(Type({"contour", job, "--frames", folder_ / "frames", "--frame-step", "100"}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("2 times"));
  EXPECT_TRUE(fs::exists(folder_ / "frames/frame_00002.png"));
  ASSERT_EQ(Type({"contour", job, "--repeat", "3"}), client::kExitGood) << errors_;
  EXPECT_THAT(output_, HasSubstr("3 times"));
  EXPECT_EQ(Type({"contour", Write("points.textproto", "name: \"a\"\n")}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("points.textproto: has no course"));
  // What would change nothing is refused.
  for (const char* option : {"--spacing", "--height", "--machine"}) {
    EXPECT_EQ(Type({"post", job, "--template", Mill("krl-full"), "--out", out, option,
                    std::string(option) == "--machine" ? "els-03" : "0.2"}),
              client::kExitWrongInput);
    EXPECT_THAT(errors_, HasSubstr("has a course, which options of a machine"));
  }
  // The short form has its speeds on the robot: what is given would be lost.
  EXPECT_EQ(Type({"post", job, "--template", Mill("krl"), "--out", out}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("no fragment uses @SPEED@, which is given"));
}

TEST_F(ContourCommand, OtherCommandsRefuseAJobOfContours) {
  const std::string job =
      Write("board.textproto", "course {\n  files: \"board.gbr\"\n}\n");
  JobFlags flags;
  flags.job_file = job;
  const auto built = BuildJob(flags);
  ASSERT_FALSE(built);
  EXPECT_THAT(built.error().message, HasSubstr("intaglio post JOB --template NAME"));
  JobSpec spec;
  spec.mutable_course()->add_files(gerber_);
  ASSERT_EQ(CheckJob(spec).size(), 1U);
  EXPECT_THAT(CheckJob(spec).front().message, HasSubstr("intaglio post JOB"));
  EXPECT_TRUE(CheckCourse(spec).empty());
  spec.mutable_course()->set_power_ratio(0.5);
  spec.mutable_course()->set_depth_mm(0.5);
  spec.mutable_course()->set_repeat_count(101);
  spec.mutable_course()->add_files("/no/such.gbr");
  spec.add_models();
  const auto found = CheckCourse(spec);
  std::vector<std::string> fields;
  for (const Finding& finding : found) fields.push_back(finding.field);
  EXPECT_THAT(fields,
              testing::UnorderedElementsAre("course.depth_mm", "course.repeat_count",
                                            "course.files[1]", "models"));
}

// The program has what the printed time says, or a note that it has not.
TEST_F(ContourCommand, AMachineGivesAProgramThePlannedSpeeds) {
  const std::string profile = folder_ / "soft.textproto";
  std::string text =
      test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  text = std::regex_replace(
      text, std::regex("\nstage_lag_s[^\n]*"),
      "\nsecond_order { natural_frequency_hz: 35 damping_ratio: 0.3 }");
  std::ofstream(profile) << text;
  const auto contour = [&](const std::string& name) {
    const std::string out = folder_ / (name + ".ngc");
    EXPECT_EQ(Type({"contour", gerber_, "--speed", "60", "--template", Mill(name),
                    "--out", out, "--machine", profile}),
              client::kExitGood)
        << errors_;
    return test::ContentOf(out);
  };
  const std::string grbl = contour("grbl");
  EXPECT_THAT(errors_, HasSubstr("has the speeds planned for els-03"));
  EXPECT_THAT(errors_, HasSubstr("$120"));
  EXPECT_THAT(grbl, HasSubstr("G4 P0\n"));
  const std::regex speed("\nF[0-9.]+");
  std::set<std::string> speeds;
  for (std::sregex_iterator it(grbl.begin(), grbl.end(), speed), end; it != end; ++it)
    speeds.insert(it->str());
  EXPECT_GT(speeds.size(), 3U);
  const std::string linuxcnc = contour("linuxcnc");
  EXPECT_THAT(errors_, HasSubstr("the program has one speed"));
  EXPECT_THAT(linuxcnc, Not(HasSubstr("G4 P0")));
}

// The profile of a mill has no axes: they are set in its controller.
TEST_F(ContourCommand, AMachineWithoutXAndYIsNamedAsOne) {
  const std::string mill = INTAGLIO_SOURCE_DIR "/deploy/machines/mill.textproto";
  EXPECT_EQ(Type({"contour", gerber_, "--machine", mill}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--machine: the profile of mill has no x and y"));
  EXPECT_THAT(errors_, HasSubstr("leave --machine out"));
}

}  // namespace
}  // namespace intaglio::cli
