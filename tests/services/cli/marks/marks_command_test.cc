#include "services/cli/marks/marks_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "engrave/io/whole_file.h"
#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "services/cli/terminal/interrupt.h"
#include "tests/services/cli/typed_command.h"

namespace intaglio::cli {
namespace {

using testing::HasSubstr;

class MarksCommand : public TypedCommand {
 protected:
  void SetUp() override {
    Write("head.textproto",
          "name: \"head\" mark_line { protocol: \"scan-head\" device: \"unix:/none\" "
          "baud: 115200 } scan_head { field_mm: 60 jump_mm_s: 5000 servo_lag_s: 0.0002 "
          "encoder_count_um: 23 }");
    Write("rows.csv", "serial\nA1\nA2\nA3\n");
    Write("job.textproto",
          "machine_file: \"head.textproto\" marks { table: \"rows.csv\" items { code { "
          "text: \"{serial}\" } } repeats { pitch_mm: 20 } web {} }");
  }

  void Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }

  int Preview(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"marks", "preview",
                                      (folder_ / "job.textproto").string()};
    words.insert(words.end(), more.begin(), more.end());
    return TypeTo(AddMarksCommand, words);
  }
};

TEST_F(MarksCommand, ShowsTheLargestSpeedOfTheWeb) {
  EXPECT_EQ(Preview(), 0) << errors_;
  EXPECT_THAT(output_, HasSubstr("item 1      "));
  EXPECT_THAT(output_, HasSubstr("web         at most "));
  EXPECT_THAT(output_, HasSubstr("verdict     good: the web runs as fast"));
}

TEST_F(MarksCommand, NamesWhatAFasterWebWouldMiss) {
  EXPECT_EQ(Preview({"--set", "marks.web.speed_mm_s=1"}), 0) << errors_;
  EXPECT_THAT(output_, HasSubstr("good: all marks are made at 1 mm/s"));
  EXPECT_EQ(Preview({"--set", "marks.web.speed_mm_s=20000"}), 3) << errors_;
  EXPECT_THAT(output_, HasSubstr("would be missed: item 1 of repeat "));
  EXPECT_THAT(output_, HasSubstr("reduce marks.web.speed_mm_s to "));
}

TEST_F(MarksCommand, IsEndedByAnInterrupt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string csv = (folder_ / "marks.csv").string();
  const auto interrupted = [&] {
    CatchInterrupts();
    std::raise(SIGINT);
    std::exit(Preview({"--csv", csv}));
  };
  EXPECT_EXIT(interrupted(), testing::ExitedWithCode(5), "");
  EXPECT_FALSE(std::filesystem::exists(csv));
}

TEST_F(MarksCommand, ReportsWhatIsNotMarked) {
  Write("plate.svg",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40mm\" height=\"20mm\" "
        "viewBox=\"0 0 40 20\"><circle cx=\"9\" cy=\"9\" r=\"5\"/>"
        "<text x=\"1\" y=\"1\">price</text></svg>");
  Write("job.textproto",
        "machine_file: \"head.textproto\" marks { items { drawing { file: "
        "\"plate.svg\" } } }");
  EXPECT_EQ(Preview(), 0) << errors_;
  EXPECT_THAT(output_, HasSubstr("warning    plate.svg"));
}

TEST_F(MarksCommand, RefusesAWebUnderAHeadWithoutAnEncoder) {
  Write("head.textproto",
        "name: \"head\" mark_line { protocol: \"scan-head\" device: \"unix:/none\" "
        "baud: 115200 } scan_head { field_mm: 60 jump_mm_s: 5000 }");
  EXPECT_EQ(Preview(), 2);
  EXPECT_THAT(errors_, HasSubstr("scan_head.encoder_count_um"));
}

TEST_F(MarksCommand, WritesMarksAndPicture) {
  const auto csv = folder_ / "marks.csv", picture = folder_ / "marks.png";
  EXPECT_EQ(Preview({"--csv", csv.string(), "--picture", picture.string()}), 0)
      << errors_;
  std::string header, first;
  std::ifstream in(csv);
  std::getline(in, header), std::getline(in, first);
  EXPECT_EQ(header, "mark,item,web_mm,closed,x_mm,y_mm,dark");
  EXPECT_EQ(first.substr(0, 8), "1,1,0,0,");
  EXPECT_GT(std::filesystem::file_size(picture), 1000U);
}

TEST_F(MarksCommand, ShowsHowDotsAreMadeAndWhatThatTakes) {
  // 200 by 100 places of even grey: some 10 000 dots.
  render::Canvas canvas(20, 10);
  for (int i = 0; i < 200; ++i) canvas.at(i % 20, i / 20) = render::Srgb(0xBCBCBC);
  ASSERT_TRUE(render::WritePng(folder_ / "grey.png", canvas));
  const auto seconds_of = [&](const std::string& image, const std::string& how) {
    Write("job.textproto",
          "machine_file: \"head.textproto\" marks { items { image { file: \"grey.png\" "
          "make: MARK_IMAGE_MAKE_DOTS " +
              image + " } placement { fit_width_mm: 20 } } }");
    EXPECT_EQ(Preview(), 0) << errors_;
    EXPECT_THAT(output_, HasSubstr(how));
    const auto at = output_.find("time        ");
    return at == std::string::npos ? 0 : std::stod(output_.substr(at + 12));
  };
  const double rows_s = seconds_of("", " of item 1, in rows, the laser is switched");
  const double each_s = seconds_of("dot_mode: MARK_DOT_MODE_EACH",
                                   " of item 1, each by itself: as dot_mode asks");
  EXPECT_GT(each_s, 10 * rows_s);
  EXPECT_GT(rows_s, 100 * 20 / 1000.0);  // 100 rows of 20 mm at 1000 mm/s
  EXPECT_EQ(Preview({"--set", "marks.pen.speed_mm_s=3000", "--set",
                     "marks.items[0].image.dot_mode=MARK_DOT_MODE_DEFAULT"}),
            0);
  EXPECT_THAT(output_, HasSubstr("each by itself: the beam passes 0.03 mm in a tick"));
  EXPECT_EQ(Preview({"--set", "marks.pen.speed_mm_s=3000", "--set",
                     "marks.items[0].image.dot_mode=MARK_DOT_MODE_ROWS"}),
            2);
  EXPECT_THAT(errors_, HasSubstr("marks.items[0].image.dot_mode: MARK_DOT_MODE_ROWS is "
                                 "not possible on head"));
}

TEST_F(MarksCommand, NamesEveryMistakeByItsField) {
  Write("job.textproto",
        "machine_file: \"head.textproto\" marks { items { text { text: \"{a}\" font: "
        "\"DejaVu Sans\" } } items { } items { drawing { file: \"none.dxf\" } hatch { "
        "distance_mm: 20 } } repeats { count: 3 } }");
  EXPECT_EQ(Preview(), 2);
  for (const char* field :
       {"marks.items[0].text.text: {a} needs a table", "marks.items[1]: is missing",
        "none.dxf does not exist", "marks.items[2].hatch.distance_mm: 20 is outside",
        "marks.repeats.pitch_mm: is missing"})
    EXPECT_THAT(errors_, HasSubstr(field));
}

TEST_F(MarksCommand, RefusesAMachineWithoutAHeadAndAJobOfPoints) {
  EXPECT_EQ(Preview({"--machine", "els-03"}), 2);
  EXPECT_THAT(errors_, HasSubstr("its profile has no mark_line"));
  Write("job.textproto", "models { file: \"a.stl\" }");
  EXPECT_EQ(Preview(), 2);
  EXPECT_THAT(errors_, HasSubstr("has no marks"));
}

TEST_F(MarksCommand, NamesWhatLiesOutsideTheField) {
  Write("job.textproto",
        "machine_file: \"head.textproto\" marks { items { code { text: \"A\" } placement "
        "{ move_y_mm: 40 } } }");
  EXPECT_EQ(Preview(), 2);
  EXPECT_THAT(errors_, HasSubstr("does not fit into the field of 60 mm"));
}

TEST_F(MarksCommand, ThePublishedExampleIsRight) {
  EXPECT_EQ(
      TypeTo(AddMarksCommand,
             {"marks", "preview", INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto",
              "--machine", (folder_ / "head.textproto").string()}),
      0)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("item 3 "));
}

// The command and its line of docs/machines/galvo.md.
TEST_F(MarksCommand, NamesThePrintMarksOfRepeats) {
  EXPECT_EQ(
      TypeTo(AddMarksCommand,
             {"marks", "preview", INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto",
              "--machine", INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-web.textproto",
              "--set", "marks.web.eye.offset_mm=-20"}),
      0)
      << errors_;
  const auto document = io::ReadWholeFile(INTAGLIO_SOURCE_DIR "/docs/machines/galvo.md",
                                          std::size_t{1} << 20);
  ASSERT_TRUE(document);
  const std::string command =
      "intaglio marks preview label.textproto --set "
      "marks.web.eye.offset_mm=-20\n```\n```\n";
  const std::size_t at = document->find(command);
  ASSERT_NE(at, std::string::npos);
  const std::size_t line = at + command.size();
  EXPECT_THAT(output_,
              HasSubstr(document->substr(line, document->find('\n', line) - line)));
}

TEST_F(MarksCommand, RefusesAnEyeThatSeesTooLate) {
  EXPECT_EQ(
      TypeTo(AddMarksCommand,
             {"marks", "preview", INTAGLIO_SOURCE_DIR "/deploy/examples/label.textproto",
              "--machine", INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-web.textproto",
              "--set", "marks.web.eye.offset_mm=110"}),
      3)
      << errors_;
  EXPECT_THAT(output_,
              HasSubstr("verdict     marks.web.eye.offset_mm: 110 mm: the photo eye "
                        "of galvo-web (scan_head.eye_mm: 120) sees"));
}

}  // namespace
}  // namespace intaglio::cli
