#include "services/drivers/grbl/grbl_text.h"

#include <gtest/gtest.h>

namespace intaglio::drivers {
namespace {

template <typename T>
T As(const std::string& line) {
  const GrblAnswer answer = ParseGrblAnswer(line);
  EXPECT_TRUE(std::holds_alternative<T>(answer)) << line;
  return std::holds_alternative<T>(answer) ? std::get<T>(answer) : T{};
}

TEST(GrblText, ReadsAStatus) {
  const auto status = As<GrblStatus>(
      "<Hold:1|MPos:1.250,-2.000,0.004|Bf:3,99|Ln:712|FS:600,1000|WCO:1.000,2.000,3.000"
      "|Pn:DP>");
  EXPECT_EQ(status.state, GrblState::kHold);
  EXPECT_EQ(status.substate, 1);
  EXPECT_FALSE(status.at_rest());
  EXPECT_EQ(*status.machine_mm, Vec3(1.25, -2, 0.004));
  EXPECT_EQ(*status.work_offset_mm, Vec3(1, 2, 3));
  EXPECT_FALSE(status.work_mm);
  EXPECT_EQ(status.free_blocks, 3);
  EXPECT_EQ(status.free_bytes, 99);
  EXPECT_EQ(status.line, 712);
  EXPECT_EQ(status.pins, "DP");
  EXPECT_EQ(*As<GrblStatus>("<Idle|WPos:1,2,3,4|FS:0,0>").work_mm, Vec3(1, 2, 3))
      << "a fourth axis";
}

TEST(GrblText, ReadsIdentityAndSettings) {
  EXPECT_EQ(As<GrblVersion>("[VER:1.1h.20190830:G-03]").serial_number, "G-03");
  EXPECT_EQ(As<GrblVersion>("[VER:1.1h.20190830:]").serial_number, "");
  EXPECT_EQ(As<GrblBuild>("[OPT:VN+,15,128]").planner_blocks, 15);
  EXPECT_EQ(As<GrblBuild>("[OPT:VN+,100,1023]").receive_bytes, 1023);
  EXPECT_EQ(As<GrblSetting>("$100=250.000").value, 250);
  EXPECT_EQ(As<GrblSetting>("$32=1 (laser mode)").number, 32);
  As<GrblBanner>("Grbl 1.1h ['$' for help]");
  EXPECT_EQ(As<GrblAlarm>("ALARM:3").code, 3);
  EXPECT_EQ(As<GrblError>("error:9").code, 9);
}

TEST(GrblText, ADamagedAnswerMeansNothing) {
  for (const char* line :
       {"<Idle|WPos:1,2|FS:0,0>", "<Idle|WPos:1,2,nan>", "<Idle|WPos:1,2,1e9>",
        "<Idle|WPos:1,2,3|Bf:x,1>", "<Idle>", "<>", "okk", "$=1", "$1=", "$1=inf", "[VER",
        "Idle|WPos:1,2,3", "<Idle|WPos:1,2,3"}) {
    As<GrblOther>(line);
  }
}

TEST(GrblText, LinesComeOutOfBytesInAnyPieces) {
  const std::string text = "ok\r\n\r\n<Idle|WPos:0,0,0>\nerror:1\r";
  for (std::size_t piece = 1; piece < 9; ++piece) {
    GrblAnswerReader reader;
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size(); at += piece) {
      reader.Feed(
          std::as_bytes(std::span(text).subspan(at, std::min(piece, text.size() - at))),
          lines);
    }
    EXPECT_EQ(lines, (std::vector<std::string>{"ok", "<Idle|WPos:0,0,0>", "error:1"}));
  }
}

TEST(GrblText, ALineThatIsTooLongIsDropped) {
  GrblAnswerReader reader;
  std::vector<std::string> lines;
  const std::string text = std::string(100000, 'x') + "\nok\n";
  reader.Feed(std::as_bytes(std::span(text)), lines);
  EXPECT_EQ(lines, std::vector<std::string>{"ok"});
}

}  // namespace
}  // namespace intaglio::drivers
