// The page of a course: its data by another parser of JSON, its model by node, where that
// is installed, against the motion.

#include "services/cli/contour/contour_page.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "services/cli/contour/contour_command.h"
#include "services/client/exit_codes.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/files/job_file.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct PagedCourse {
  ContourWork work;
  Course whole;
  ContourMotion motion;
};

/// A disc, a hole, and on a machine a square of 20 mm with a round corner.
PagedCourse MakePagedCourse(bool on_machine) {
  Course course;
  course.set_tool_diameter_mm(0.5);
  course.set_speed_mm_s(on_machine ? 60 : 10);
  CourseFiles files;
  if (on_machine) {
    course.set_make(COURSE_MAKE_CURVES);
    course.set_power_ratio(0.5);
    files.curves.push_back(
        {"square",
         {contour::MakeLine({0, 0}, {20, 0}), contour::MakeLine({20, 0}, {20, 15}),
          contour::MakeArcBetween({20, 15}, {15, 20}, {15, 15}, true),
          contour::MakeLine({15, 20}, {0, 20}), contour::MakeLine({0, 20}, {0, 0})},
         true});
  } else {
    files.elements.push_back({contour::Circle{{3, 3}, 2}, "disc"});
    files.holes.push_back({{9, 3}, 0.8});
  }
  PagedCourse made{{}, WithDefaults(course), {}};
  auto work = MakeContourWork(made.whole, files, {0, 0});
  EXPECT_TRUE(work) << (work ? "" : work.error().message);
  made.work = std::move(*work);
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
  machine.mutable_second_order()->set_natural_frequency_hz(30);
  machine.mutable_second_order()->set_damping_ratio(0.4);
  machine.set_position_tolerance_um(80);
  auto motion = MotionOf(made.work, made.whole, on_machine ? &machine : nullptr, {0, 0});
  EXPECT_TRUE(motion) << (motion ? "" : motion.error().message);
  made.motion = std::move(*motion);
  return made;
}

/// What is between the script's begin and its end.
std::string ScriptOf(const std::string& page, const std::string& id) {
  const auto name = page.find("<script id=\"" + id + "\"");
  EXPECT_NE(name, std::string::npos) << id;
  const auto begin = page.find('>', name) + 1;
  return page.substr(begin, page.find("</script>", begin) - begin);
}

const google::protobuf::Value& FieldOf(const google::protobuf::Struct& object,
                                       const std::string& name) {
  return object.fields().at(name);
}

TEST(ContourPage, ItsDataAreTheMotion) {
  const PagedCourse made = MakePagedCourse(false);
  const std::string page = PageOf(made.work, made.motion, 0.5, "a<b>.gbr");
  EXPECT_THAT(page, HasSubstr("<title>a&lt;b&gt;.gbr</title>"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* part : {"http://", "https://", "src=", "href=", "url("})
    EXPECT_THAT(page, Not(HasSubstr(part))) << "it loads nothing";
  google::protobuf::Struct data;
  ASSERT_TRUE(
      google::protobuf::util::JsonStringToMessage(ScriptOf(page, "data"), &data).ok());
  EXPECT_NEAR(FieldOf(data, "duration").number_value(), made.motion.duration_s, 1e-8);
  const auto& legs = FieldOf(data, "legs").list_value();
  ASSERT_EQ(legs.values_size(), static_cast<int>(made.motion.legs.size()));
  for (int i = 0; i < legs.values_size(); ++i) {
    const auto& leg = legs.values(i).struct_value();
    const MotionLeg& expected = made.motion.legs[static_cast<std::size_t>(i)];
    EXPECT_EQ(FieldOf(leg, "kind").string_value(), NameOf(expected.kind));
    EXPECT_NEAR(FieldOf(leg, "begin").number_value(), expected.begin_s, 1e-8);
    EXPECT_EQ(FieldOf(leg, "edges").list_value().values_size(),
              static_cast<int>(expected.edges.size()));
    if (expected.kind == LegKind::kDrill) {
      EXPECT_NEAR(FieldOf(leg, "diameter").number_value(), 0.8, 1e-9);
    }
  }
  // Arcs have 65 places: the highest is missed by r (1 - cos(pi / 64)) at most, 0.0015
  // mm. The disc of 2 mm with its tool, a margin of 1.5 mm, and the way from the origin.
  const auto& extent = FieldOf(data, "extent").list_value();
  EXPECT_NEAR(extent.values(0).number_value(), -1.5, 1e-6);
  EXPECT_NEAR(extent.values(2).number_value(), 9 + 1.5, 1e-6);
  EXPECT_NEAR(extent.values(3).number_value(), 3 + 1.25 + 1.5, 0.002);
}

/// Runs the page's model and `script` behind it, and returns what that prints.
std::string NodePrints(const std::string& page, const std::string& script) {
  const auto file = test::FreshFolder() / "model.js";
  std::ofstream(file) << ScriptOf(page, "model")
                      << "const data = " << ScriptOf(page, "data") << ";\n"
                      << script;
  return post::fixture::OutputOf("node " + file.string());
}

TEST(ContourPage, ItsModelFindsTheToolWhereTheMotionHasIt) {
  if (!post::fixture::IsInstalled("node")) GTEST_SKIP() << "no node: install nodejs";
  for (const bool on_machine : {false, true}) {
    const PagedCourse made = MakePagedCourse(on_machine);
    const std::string page = PageOf(made.work, made.motion, 0.5, "board");
    std::istringstream lines(
        NodePrints(page,
                   "for (let k = 0; k <= 500; ++k) {\n"
                   "  const s = stateAt(data, data.duration * k / 500);\n"
                   "  console.log(s.leg, s.place[0], s.place[1], s.speed);\n}\n"));
    // Ways are linear over 5 ms: at the acceleration a of a corner they miss a h^2 / 8.
    const double near_mm = on_machine ? 0.05 : 1e-5;
    int count = 0;
    for (int k = 0; k <= 500; ++k) {
      std::size_t leg = 0;
      double x = 0, y = 0, speed = 0;
      if (!(lines >> leg >> x >> y >> speed)) break;
      ++count;
      const double time_s = made.motion.duration_s * k / 500;
      const ToolState now = made.motion.At(time_s);
      EXPECT_NEAR(x, now.place_mm.x(), near_mm) << time_s;
      EXPECT_NEAR(y, now.place_mm.y(), near_mm) << time_s;
      if (!on_machine && leg == now.leg) {
        EXPECT_NEAR(speed, now.speed_mm_s, 1e-3);
      }
    }
    EXPECT_EQ(count, 501);
  }
}

TEST(ContourPage, ItsPlayerPlaysPausesStopsAndHasAFeed) {
  if (!post::fixture::IsInstalled("node")) GTEST_SKIP() << "no node: install nodejs";
  const PagedCourse made = MakePagedCourse(false);
  const std::string page = PageOf(made.work, made.motion, 0.5, "board");
  const std::string printed = NodePrints(page, R"(
const p = new Player(10);
const steps = [];
p.step(1); steps.push(p.time);             // not running
p.play(); p.step(5); p.step(6); steps.push(p.time);
p.pause(); p.step(8); steps.push(p.time);  // stays
p.play(); p.step(9); p.feed = 3; p.step(10); steps.push(p.time);
p.step(100); steps.push(p.time, p.running);
p.play(); steps.push(p.time);              // again from the begin
p.step(101); p.step(102); p.stop(); steps.push(p.time, p.running);
p.seek(99); steps.push(p.time);
console.log(JSON.stringify(steps));
)");
  EXPECT_EQ(printed, "[0,1,1,4,10,false,0,0,false,10]\n");
}

class ContourPageCommand : public TypedCommand {};

TEST_F(ContourPageCommand, WritesThePage) {
  const std::string board = folder_ / "board.gbr", page = folder_ / "board.html";
  std::ofstream(board)
      << "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,2*%\nD10*\nX3000000Y0D03*\nM02*\n";
  ASSERT_EQ(TypeTo(AddContourCommand, {"contour", board, "--page", page}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("page          " + page));
  EXPECT_THAT(test::ContentOf(page), HasSubstr("<title>board.gbr</title>"));
}

}  // namespace
}  // namespace intaglio::cli
