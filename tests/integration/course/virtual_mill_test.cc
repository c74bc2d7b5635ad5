// A board on the virtual mill of `intaglio run`, as a user types it. The judge is the
// machine's own record of its tool, by cells of the tests' own: which pads hang together.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <set>

#include "engrave/formats/tool_way.h"
#include "proto/report.pb.h"
#include "tests/engrave/contour/files/kicad_text.h"
#include "tests/integration/course/left_copper.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// Two pads of each of two nets; B is joined behind, so its pads are pieces of their own.
std::string BoardText() {
  contour::test::KicadText text;
  text.Outline(0, 0, 20, 10);
  text.Footprint("R1", 0, 0);
  text.Pad("1", "circle", 3, 3, 2, 2, "A", 0.8);
  text.Pad("2", "circle", 17, 3, 2, 2, "A", 0.8);
  text.Pad("3", "circle", 3, 7, 2, 2, "B", 0.8);
  text.Pad("4", "rect", 17, 7, 2, 2, "B", 0.8);
  text.EndFootprint();
  text.Segment(3, 3, 10, 4.5, 0.5, "A");
  text.Segment(10, 4.5, 17, 3, 0.5, "A");
  text.Segment(3, 7, 17, 7, 0.5, "B", "B.Cu");
  return text.Text();
}

class VirtualMill : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder_ / "board.kicad_pcb") << BoardText();
    std::ofstream(folder_ / "plate.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" )"
        << R"(viewBox="0 0 20 20"><rect x="4" y="4" width="12" height="12"/></svg>)";
  }
  void WriteJob(const std::string& machine, const std::string& course) const {
    std::ofstream(folder_ / "board.textproto")
        << "name: \"board\" machine_file: \"" << machine << "\" course { " << course
        << " }\n";
  }
  void WriteBoardJob() const {
    WriteJob("mill",
             "files: \"board.kicad_pcb\" tool_diameter_mm: 0.3 pass_count: 2 "
             "depth_mm: 0.1 speed_mm_s: 60 plunge_mm_s: 10 drill_diameter_mm: 0");
  }
  Ended Run(std::vector<std::string> more = {}) const {
    std::vector<std::string> typed = {
        "run",         folder_ / "board.textproto",        "--out",       folder_ / "out",
        "--materials", folder_ / "materials.db",           "--domain",    "49",
        "--tag",       "vmill" + std::to_string(getpid()), "--no-record", "--speed",
        "10"};
    typed.insert(typed.end(), more.begin(), more.end());
    Running run(Program("intaglio"), typed, folder_ / "run.txt");
    return run.WaitForEnd(150s);
  }
  JobReport Report() const {
    JobReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    TextIn(folder_ / "out/report.json"), &report)
                    .ok());
    return report;
  }
  /// At work, from the record.
  std::vector<ToolStep> Work() const {
    const auto way = formats::ReadToolWay(folder_ / "out/cut.rec");
    EXPECT_TRUE(way) << way.error().message;
    std::vector<ToolStep> work;
    ToolStep step;
    for (const formats::ToolWayStep& end : way->steps) {
      step.to_mm = end.end_mm;
      step.on = end.is_on;
      if (step.lowest_mm() < -0.05) work.push_back(step);
      step.from_mm = step.to_mm;
    }
    return work;
  }
  fs::path folder_ = test::FreshFolder();
};

TEST_F(VirtualMill, ABoardIsMadeAndProvedFromWhatWasCleared) {
  WriteBoardJob();
  const Ended run = Run();
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("pieces      4 left, 4 planned, 0 joined, 0 split"));
  const LeftCopper copper(Work(), 0.15);
  std::set<int> pieces;
  const std::map<std::string, Vec2> pads_mm = {
      {"A1", {3, -3}}, {"A2", {17, -3}}, {"B3", {3, -7}}, {"B4", {17, -7}}};
  std::map<std::string, int> island;
  for (const auto& [name, place] : pads_mm) {
    island[name] = copper.IslandAt(place + Vec2(0.7, 0));
    EXPECT_GT(island[name], 0) << name << " is cut away";
    pieces.insert(island[name]);
  }
  EXPECT_EQ(island["A1"], island["A2"]);
  pieces.insert(copper.IslandAt({-0.9, 0.9}));
  EXPECT_EQ(pieces.size(), 4U);
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.evidence(), "material");
  EXPECT_EQ(report.marks().cut().pieces_left(), 4U);
  EXPECT_NEAR(report.marks().cut().deepest_mm(), 0.1, 0.002);
  for (const char* picture : {"sheet.png", "views.png"})
    EXPECT_GT(fs::file_size(folder_ / "out" / picture), 1000U) << picture;
  Running again(Program("intaglio"), {"verify", folder_ / "out"}, folder_ / "v.txt");
  EXPECT_EQ(again.WaitForEnd(60s).exit_code, 0);
}

TEST_F(VirtualMill, AToolThatIsNotTheJobsIsFoundInTheSheet) {
  WriteBoardJob();
  std::ofstream(folder_ / "wide.textproto") << "mill { tool_diameter_mm: 0.4 }";
  const Ended wide = Run({"--truth", folder_ / "wide.textproto"});
  EXPECT_EQ(wide.exit_code, 3) << wide.output;
  EXPECT_THAT(wide.output, HasSubstr("cleared beside the plan"));
  std::ofstream(folder_ / "low.textproto") << "mill { sheet_height_mm: -0.12 }";
  const Ended low = Run({"--truth", folder_ / "low.textproto"});
  EXPECT_EQ(low.exit_code, 3) << low.output;
  EXPECT_THAT(low.output, HasSubstr("pieces that are to be apart hang together"));
  std::ofstream(folder_ / "thin.textproto") << "mill { sheet_thickness_mm: 0.09 }";
  const Ended thin = Run({"--truth", folder_ / "thin.textproto"});
  EXPECT_EQ(thin.exit_code, 3) << thin.output;
  EXPECT_THAT(thin.output, HasSubstr("cut through where they are to hold"));
}

TEST_F(VirtualMill, ALaserCutsAPlate) {
  WriteJob("laser-cutter",
           "files: \"plate.svg\" make: COURSE_MAKE_CUT tool_diameter_mm: 0.2 "
           "power_ratio: 0.6 speed_mm_s: 40");
  const Ended run = Run();
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("pieces      2 left, 2 planned"));
  EXPECT_TRUE(Report().marks().cut().laser());
}

TEST_F(VirtualMill, WhatItCannotDoIsRefusedWithTheWayOut) {
  WriteBoardJob();
  const Ended lockstep = Run({"--lockstep"});
  EXPECT_EQ(lockstep.exit_code, 2) << lockstep.output;
  EXPECT_THAT(lockstep.output, HasSubstr("--speed"));
  Running up(Program("intaglio"),
             {"up", "--machine", "mill", "--folder", folder_ / "shop", "--materials",
              folder_ / "materials.db", "--domain", "49", "--tag",
              "vmill" + std::to_string(getpid())},
             folder_ / "up.txt");
  const Ended shop = up.WaitForEnd(60s);
  EXPECT_NE(shop.exit_code, 0) << shop.output;
  EXPECT_THAT(shop.output, HasSubstr("has no virtual machine here"));
}

}  // namespace
}  // namespace intaglio::testing
