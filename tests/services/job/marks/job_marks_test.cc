#include "services/job/marks/job_marks.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>

#include "services/job/files/job_file.h"
#include "tests/engrave/mark/burnt_picture.h"
#include "tests/engrave/matrix_code/code_reader.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

constexpr double kLineMm = 0.12;

FileBytes Bytes(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

JobSpec Job(const std::string& text) {
  auto job = ParseJob(text, JobFileFormat::kText, "job");
  EXPECT_TRUE(job) << (job ? "" : job.error().message);
  return job.value_or(JobSpec());
}

MachineSpec Head() {
  MachineSpec machine;
  machine.set_name("head");
  machine.mutable_scan_head()->set_field_mm(100);
  machine.mutable_scan_head()->set_jump_mm_s(5000);
  return machine;
}

Result<mark::MarkSet> Make(const JobSpec& job, std::vector<FileBytes> files = {}) {
  Warnings warnings;
  auto made =
      MakeJobMarks(job, Head(), std::move(files), ReadLimits(), warnings, nullptr);
  EXPECT_TRUE(warnings.empty());
  return made;
}

Box3 ExtentOfMarks(const std::vector<mark::Mark>& marks) {
  Box3 box;
  for (const mark::Mark& mark : marks)
    for (const Vec2& p : mark::PlacesOf(mark, 0.001))
      box.Extend(Vec3(p.x(), p.y(), mark.web_mm));
  return box;
}

const char* const kPlate = R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm"
  height="20mm" viewBox="0 0 40 20">
  <g id="rim"><rect x="0" y="0" width="40" height="20"/></g>
  <g id="hole"><circle cx="20" cy="10" r="5"/></g></svg>)";

TEST(JobMarks, ADrawingIsPlacedAndHasItsPen) {
  const auto set = Make(Job(R"(marks {
      items { drawing { file: "plate.svg" } pen { speed_mm_s: 300 pass_count: 2 }
              placement { rotate_deg: 90 fit_width_mm: 10 move_x_mm: 3 } }
      pen { power_ratio: 0.8 frequency_hz: 40000 } })"),
                        {Bytes(kPlate)});
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 2U);
  ASSERT_EQ(set->pens.size(), 1U);
  EXPECT_EQ(set->pens[0].speed_mm_s, 300);
  EXPECT_EQ(set->pens[0].power_ratio, 0.8);
  EXPECT_EQ(set->pens[0].frequency_hz, 40000);
  EXPECT_EQ(set->pens[0].pass_count, 2U);
  const Box3 box = ExtentOfMarks(set->marks);
  EXPECT_NEAR(box.size_mm().x(), 10, 1e-9);
  EXPECT_NEAR(box.size_mm().y(), 20, 1e-9);
  EXPECT_NEAR(box.center_mm().x(), 3, 1e-9);
  EXPECT_NEAR(box.center_mm().y(), 0, 1e-9);
}

TEST(JobMarks, LayersStayInTheirPlaceAndMissingOnesAreNamed) {
  const auto set = Make(Job(R"(marks { items { placement { centre: false }
      drawing { file: "plate.svg" layers: "hole" } } })"),
                        {Bytes(kPlate)});
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 1U);
  EXPECT_NEAR(ExtentOfMarks(set->marks).center_mm().x(), 20, 0.01);
  const auto none =
      Make(Job(R"(marks { items { drawing { file: "plate.svg" layers: "holes" } } })"),
           {Bytes(kPlate)});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("marks.items[0].drawing.layers"));
  EXPECT_THAT(none.error().message, HasSubstr("\"hole\", \"rim\""));
}

// Trochimczuk 2008 ch. 6.6.1: power and speed by the pen's colour.
TEST(JobMarks, EveryPenOfAPlotHasItsPowerAndSpeed) {
  const std::string plot = "IN;SP1;PU0,0;PD400,0;SP2;PU0,400;PD400,400;";
  const auto set = Make(Job(R"(marks {
      items { drawing { file: "plan.plt" layers: "SP1" }
              placement { centre: false } pen { speed_mm_s: 300 power_ratio: 0.9 } }
      items { drawing { file: "plan.plt" layers: "SP2" }
              placement { centre: false } pen { speed_mm_s: 2000 power_ratio: 0.2 } } })"),
                        {Bytes(plot), Bytes(plot)});
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 2U);
  for (const mark::Mark& mark : set->marks) {
    // 40 units of a plotter are a millimetre: pen 2 draws 10 mm above pen 1.
    const bool is_second = mark::PlacesOf(mark, 0.001).front().y() > 5;
    EXPECT_EQ(set->pens[mark.pen].speed_mm_s, is_second ? 2000 : 300);
    EXPECT_EQ(set->pens[mark.pen].power_ratio, is_second ? 0.2 : 0.9);
  }
  EXPECT_NE(set->marks[0].pen, set->marks[1].pen);
}

// The plate of 40 x 20 with a hole of radius 5.
TEST(JobMarks, FillsLeaveIslandsFree) {
  const auto set = Make(Job(R"(marks { items { drawing { file: "plate.svg" }
      hatch { distance_mm: 0.05 angle_deg: 30 contour: false } } })"),
                        {Bytes(kPlate)});
  ASSERT_TRUE(set) << set.error().message;
  double length = 0;
  for (const mark::Mark& mark : set->marks) {
    ASSERT_EQ(mark.places.size(), 2U);
    length += mark::LengthOf(mark);
    // A chord is nowhere nearer to the middle than the hole's radius.
    const Vec2 a = mark.places[0].at_mm, way = mark.places[1].at_mm - a;
    const double t = std::clamp(-a.dot(way) / way.squaredNorm(), 0.0, 1.0);
    EXPECT_GT((a + t * way).norm(), 5 - 0.002);
  }
  EXPECT_NEAR(length * 0.05, 800 - 25 * 3.14159265, 3);
}

TEST(JobMarks, RepeatsLieAPitchApartOnAPieceAndAlongAWeb) {
  const std::string items =
      "items { drawing { file: \"plate.svg\" layers: \"hole\" } } "
      "repeats { count: 3 pitch_mm: 30 } ";
  const auto piece = Make(Job("marks { " + items + "}"), {Bytes(kPlate)});
  ASSERT_TRUE(piece);
  ASSERT_EQ(piece->marks.size(), 3U);
  EXPECT_NEAR(ExtentOfMarks({piece->marks[2]}).center_mm().x(), 60, 1e-9);
  const auto web = Make(Job("marks { " + items + "web {} }"), {Bytes(kPlate)});
  ASSERT_TRUE(web);
  EXPECT_NEAR(ExtentOfMarks({web->marks[2]}).center_mm().x(), 0, 1e-9);
  EXPECT_EQ(web->marks[2].web_mm, 60);
}

std::string FontFile() {
  const char* const kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  return kFont;
}

FileBytes FontBytes() {
  std::FILE* file = std::fopen(FontFile().c_str(), "rb");
  if (file == nullptr) return {};
  FileBytes bytes(1 << 21);
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file));
  std::fclose(file);
  return bytes;
}

TEST(JobMarks, TextsHaveTheFieldsOfTheirRow) {
  const JobSpec job = Job(fmt::format(R"(marks {{
      items {{ text {{ text: "{{name}} {{n}}" font: "{}" height_mm: 4 }} }}
      table: "names.csv" first_number: 7 number_digits: 3
      repeats {{ pitch_mm: 30 }} web {{}} }})",
                                      FontFile()));
  const auto set = Make(job, {FontBytes(), Bytes("name\nI\nIIIII\n")});
  ASSERT_TRUE(set) << set.error().message;
  std::map<double, int> letters;
  for (const mark::Mark& mark : set->marks) ++letters[mark.web_mm];
  ASSERT_EQ(letters.size(), 2U);
  // I is one contour each; 8 has two more than 7.
  EXPECT_EQ(letters[30] - letters[0], 4 + 2);
  const auto broken = Make(job, {FontBytes(), Bytes("nam\nI\n")});
  ASSERT_FALSE(broken);
  EXPECT_EQ(
      broken.error().message,
      "marks.items[0].text.text: names.csv has no column 'name', did you mean nam?; "
      "it has: nam");
  const auto unreadable = Make(job, {FontBytes(), Bytes("name\nI\n\xff\xff\n")});
  ASSERT_FALSE(unreadable);
  EXPECT_THAT(unreadable.error().message, HasSubstr("(repeat 2, line 3 of names.csv)"));
}

/// A BMP of 24 bits, 4 x 2 pixels: dark, dark, bright, dark above bright, bright, dark,
/// dark.
std::string SmallBmp() {
  std::string bmp("BM", 2);
  const auto add = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bmp += static_cast<char>(value >> (8 * i) & 0xff);
  };
  add(54 + 24, 4), add(0, 4), add(54, 4), add(40, 4), add(4, 4), add(2, 4), add(1, 2);
  add(24, 2), add(0, 4), add(24, 4), add(2835, 4), add(2835, 4), add(0, 4), add(0, 4);
  for (const int grey : {255, 255, 0, 0, 0, 0, 255, 0}) bmp += std::string(3, char(grey));
  return bmp;
}

TEST(JobMarks, ImagesBecomeRowsThatComeBack) {
  const auto set = Make(Job(R"(marks { items { image { file: "a.bmp" distance_mm: 0.5 }
      placement { centre: false } } })"),
                        {Bytes(SmallBmp())});
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->marks.size(), 3U);
  const auto expect = [&](std::size_t i, const Vec2& from, const Vec2& to) {
    EXPECT_EQ(set->marks[i].places[0].at_mm, from);
    EXPECT_EQ(set->marks[i].places[1].at_mm, to);
  };
  expect(0, {1, 0.25}, {2, 0.25});
  expect(1, {2, 0.75}, {1.5, 0.75});
  expect(2, {1, 0.75}, {0, 0.75});
}

TEST(JobMarks, AScaledImageKeepsItsDistance) {
  const auto set = Make(Job(R"(marks { items { image { file: "a.bmp" distance_mm: 0.1 }
      placement { fit_width_mm: 4 } } })"),
                        {Bytes(SmallBmp())});
  ASSERT_TRUE(set) << set.error().message;
  std::vector<double> rows;
  for (const mark::Mark& mark : set->marks) rows.push_back(mark.places[0].at_mm.y());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  ASSERT_EQ(rows.size(), 20U);
  EXPECT_NEAR(rows[1] - rows[0], 0.1, 1e-9);
  EXPECT_NEAR(ExtentOfMarks(set->marks).size_mm().x(), 4, 1e-9);
}

TEST(JobMarks, DotsFollowTheBrightness) {
  // As many dots as dark area: half of it has as many as there are dark pixels.
  const auto set = Make(Job(R"(marks { items {
      image { file: "a.bmp" make: MARK_IMAGE_MAKE_DOTS distance_mm: 0.1 dot_mm: 0.03 }
      placement { fit_width_mm: 40 } } })"),
                        {Bytes(SmallBmp())});
  ASSERT_TRUE(set) << set.error().message;
  // 400 x 200 places, of which 5 of 8 are dark; edges are smoothed when it is enlarged.
  EXPECT_NEAR(static_cast<double>(set->marks.size()), 50000, 2500);
  for (const mark::Mark& mark : set->marks) EXPECT_NEAR(mark::LengthOf(mark), 0.03, 1e-9);
}

mark::BurntPicture PictureOf(const std::vector<mark::Mark>& marks) {
  const Box3 box = ExtentOfMarks(marks);
  const Vec2 rim(3, 3), low = box.min_mm.head<2>() - rim,
                        high = box.max_mm.head<2>() + rim;
  return mark::Burn(marks, kLineMm, low, high, 0.06);
}

TEST(JobMarks, QrCodesAreReadFromWhatIsBurnt) {
  if (!matrix_code::CanReadQr()) GTEST_SKIP() << "zbar is not installed";
  for (const char* fill :
       {"distance_mm: 0.1", "distance_mm: 0.11 angle_deg: 45 cross: true",
        "distance_mm: 0.1 contour: true"}) {
    const auto set = Make(Job(fmt::format(
        "marks {{ items {{ code {{ kind: MARK_CODE_KIND_QR text: "
        "\"https://example.org/1\" "
        "module_mm: 0.6 }} placement {{ rotate_deg: 10 }} hatch {{ inset_mm: 0.06 {} }} "
        "}} }}",
        fill)));
    ASSERT_TRUE(set) << set.error().message;
    EXPECT_EQ(matrix_code::ReadQr(PictureOf(set->marks)), "https://example.org/1")
        << fill;
  }
}

/// 1000 by INTAGLIO_CODE_COUNT=1000.
std::size_t CodeCount() {
  const char* const asked = std::getenv("INTAGLIO_CODE_COUNT");
  return asked == nullptr ? 60 : std::stoul(asked);
}

TEST(JobMarks, DataMatricesOfATableAreAllReadFromAWeb) {
  if (!matrix_code::CanReadDataMatrix()) GTEST_SKIP() << "libdmtx is not installed";
  std::string table = "serial,owner\n";
  for (std::size_t i = 0; i < CodeCount(); ++i)
    table += fmt::format("SN-{:05},owner {}\n", 7919 * i % 100000, i);
  const JobSpec job = Job(R"(marks {
      items { code { text: "{serial}/{n}/{owner}" module_mm: 0.5 }
              hatch { distance_mm: 0.1 inset_mm: 0.05 } }
      table: "serials.csv" repeats { pitch_mm: 15 } web {} })");
  const auto made = Make(job, {Bytes(table)});
  ASSERT_TRUE(made) << made.error().message;
  const auto ordered = OrderJobMarks(job, Head(), *made);
  ASSERT_TRUE(ordered) << ordered.error().message;
  EXPECT_EQ(ordered->marks.size(), made->marks.size());
  std::map<double, std::vector<mark::Mark>> pieces;
  for (const mark::Mark& mark : ordered->marks) pieces[mark.web_mm].push_back(mark);
  ASSERT_EQ(pieces.size(), CodeCount());
  std::size_t i = 0;
  for (const auto& [web_mm, marks] : pieces) {
    EXPECT_NEAR(web_mm, 15 * static_cast<double>(i), 1e-6);
    EXPECT_EQ(matrix_code::ReadDataMatrix(PictureOf(marks)),
              fmt::format("SN-{:05}/{}/owner {}", 7919 * i % 100000, i + 1, i));
    ++i;
  }
}

TEST(JobMarks, TooManyMarksAreRefused) {
  const auto set = Make(Job(R"(marks { items { drawing { file: "plate.svg" } hatch {} }
      repeats { count: 100000 pitch_mm: 1 } })"),
                        {Bytes(kPlate)});
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(set.error().message, HasSubstr("marks.repeats.count"));
}

TEST(JobMarks, WhatADrawingHoldsAndIsNotMarkedIsReportedOnce) {
  const std::string svg = R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm"
      height="20mm" viewBox="0 0 40 20"><circle cx="20" cy="10" r="5"/>
      <text x="1" y="1">price</text></svg>)";
  Warnings warnings;
  const auto set = MakeJobMarks(Job(R"(marks { items { drawing { file: "plate.svg" } }
      repeats { count: 3 pitch_mm: 1 } })"),
                                Head(), {Bytes(svg)}, ReadLimits(), warnings, nullptr);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(set->marks.size(), 3U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].code, WarningCode::kLeftOut);
  EXPECT_THAT(warnings[0].text, HasSubstr("plate.svg"));
  EXPECT_THAT(warnings[0].text, HasSubstr("text"));
}

TEST(JobMarks, ProgressMayCancel) {
  Warnings warnings;
  const auto set = MakeJobMarks(Job(R"(marks { items { code { text: "A" } } })"), Head(),
                                {}, ReadLimits(), warnings,
                                [](std::uint64_t, std::uint64_t) { return false; });
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace intaglio
