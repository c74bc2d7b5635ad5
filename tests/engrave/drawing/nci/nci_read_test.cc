// Expected values: by geometry, by the same path as a DXF polyline, whose arcs are given
// by another parameter (the bulge), and by the codes of nci_codes.h.

#include "engrave/drawing/nci/nci_read.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/pieces.h"
#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Record {
  int code;
  std::string parameters;
};

std::string File(const std::vector<Record>& records, bool has_end = true) {
  std::string text;
  for (const Record& r : records) text += fmt::format("{}\n{}\n", r.code, r.parameters);
  return has_end ? text + "1003\n0 0 0\n" : text;
}

Drawing Read(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadNci(text, options);
  EXPECT_TRUE(drawing) << (drawing ? "" : drawing.error().message);
  return drawing ? *drawing : Drawing();
}
Error ErrorOf(const std::string& text, const ReadOptions& options = {}) {
  const auto drawing = ReadNci(text, options, "a.nci");
  EXPECT_FALSE(drawing);
  return drawing ? Error() : drawing.error();
}

FlatDrawing FlatOf(const Drawing& drawing) {
  const auto flat = Flatten(drawing);
  EXPECT_TRUE(flat);
  return flat ? *flat : FlatDrawing();
}

/// The finding of this name, or an empty one.
FileFinding FindingOf(const Drawing& drawing, const std::string& what) {
  for (const FileFinding& finding : drawing.findings) {
    if (finding.what.find(what) != std::string::npos) return finding;
  }
  return {};
}

TEST(NciRead, FeedMovesAreCurvesAndRapidsJumps) {
  const Drawing drawing = Read(File({{0, "0 1. 2. 3. -2. 0"},
                                     {1, "0 4. 2. 3. 100. 0"},
                                     {1, "0 4. 6. 5. -1. 0"},
                                     {1, "0 9. 9. 5. -2. 0"},
                                     {1, "40 9. 8. 5. 100. 0"}}));
  ASSERT_EQ(drawing.curves.size(), 2U);
  EXPECT_EQ(std::get<Polyline>(drawing.curves[0].pieces[0]).points_mm,
            (PointList{{1, 2, 3}, {4, 2, 3}, {4, 6, 5}}));
  EXPECT_EQ(std::get<Polyline>(drawing.curves[1].pieces[0]).points_mm,
            (PointList{{9, 9, 5}, {9, 8, 5}}));
  EXPECT_TRUE(drawing.findings.empty());
}

TEST(NciRead, ArcsAreExactInBothDirections) {
  const auto arc_of = [](int code, const std::string& parameters) {
    const Drawing drawing = Read(File({{0, "0 2 0 -1 -2 0"}, {code, parameters}}));
    EXPECT_EQ(drawing.curves.size(), 1U);
    return std::get<EllipticArc>(drawing.curves.at(0).pieces.at(0));
  };
  // From (2, 0) about (1, 0) to (1, 1): a quarter to the left, three to the right.
  EXPECT_NEAR(arc_of(3, "0 0 1 1 1 0 -1 100 0 0").sweep_rad, pi / 2, 1e-12);
  EXPECT_NEAR(arc_of(2, "0 0 1 1 1 0 -1 100 0 0").sweep_rad, -3 * pi / 2, 1e-12);
  EXPECT_NEAR(arc_of(2, "0 0 2 0 1 0 -1 100 0 1").sweep_rad, -2 * pi, 1e-12);
  EXPECT_NEAR(arc_of(3, "0 0 2 0 1 0 -1 100 0").sweep_rad, 2 * pi, 1e-12);
  EXPECT_EQ(arc_of(3, "0 0 2 0 1 0 -1 100 0").center_mm, Vec3(1, 0, -1));
  // The first two parameters are the plane and the compensation in either order.
  EXPECT_NEAR(arc_of(3, "40 0 1 1 1 0 -1 100 0 0").sweep_rad, pi / 2, 1e-12);
  EXPECT_NEAR(arc_of(3, "0 40 1 1 1 0 -1 100 0 0").sweep_rad, pi / 2, 1e-12);
}

/// A path of lines and arcs, each arc by its bulge, tan(sweep / 4): as NCI, with centres,
/// and as a polyline of a DXF.
class RandomPath {
 public:
  explicit RandomPath(std::uint32_t seed) : random_(seed) {
    Vec2 at(Number(-50, 50), Number(-50, 50));
    Line(at, 0);
    records_.push_back({0, fmt::format("0 {:.9f} {:.9f} -1.5 -2 0", at.x(), at.y())});
    for (int i = 0; i < 12; ++i) {
      const Vec2 to(Number(-50, 50), Number(-50, 50));
      const double bulge = i % 3 == 0 ? 0 : Number(-3, 3);
      Move(at, to, bulge);
      at = to;
    }
    Line(at, 0);
  }
  std::string Nci() const { return File(records_); }
  std::string Dxf() const {
    return Entities("0 LWPOLYLINE|8 0|38 -1.5|70 0" + vertices_);
  }

 private:
  double Number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  void Line(const Vec2& at, double bulge) {
    if (is_first_) {
      is_first_ = false;
      return;
    }
    vertices_ += fmt::format("|10 {:.9f}|20 {:.9f}|42 {:.12f}", at.x(), at.y(), bulge);
  }
  void Move(const Vec2& at, const Vec2& to, double bulge) {
    Line(at, bulge);
    if (bulge == 0) {
      records_.push_back({1, fmt::format("0 {:.9f} {:.9f} -1.5 90 0", to.x(), to.y())});
      return;
    }
    // The centre is (1 - b^2) / (4 b) chords to the left of the middle of the chord.
    const Vec2 chord = to - at;
    const Vec2 center =
        (at + to) / 2 + Vec2(-chord.y(), chord.x()) * ((1 - bulge * bulge) / (4 * bulge));
    records_.push_back(
        {bulge > 0 ? 3 : 2, fmt::format("0 0 {:.9f} {:.9f} {:.9f} {:.9f} -1.5 90 0 0",
                                        to.x(), to.y(), center.x(), center.y())});
  }

  std::mt19937 random_;
  bool is_first_ = true;
  std::vector<Record> records_;
  std::string vertices_;
};

TEST(NciRead, IsThePathOfTheSamePolylineOfADxf) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    const RandomPath path(seed);
    const auto dxf = ReadDxf(path.Dxf());
    ASSERT_TRUE(dxf) << dxf.error().message;
    const FlatDrawing nci_flat = FlatOf(Read(path.Nci())), dxf_flat = FlatOf(*dxf);
    ASSERT_EQ(nci_flat.curves.size(), 1U);
    ASSERT_EQ(dxf_flat.curves.size(), 1U);
    const FlatCurve &a = nci_flat.curves[0], &b = dxf_flat.curves[0];
    EXPECT_NEAR(LengthOf(a) / LengthOf(b), 1, 1e-6) << seed;
    EXPECT_NEAR(AreaOf(a), AreaOf(b), 1e-4 * LengthOf(b)) << seed;
    const Box3 box = ExtentOf(nci_flat), other = ExtentOf(dxf_flat);
    EXPECT_TRUE(box.min_mm.isApprox(other.min_mm, 1e-4)) << seed;
    EXPECT_TRUE(box.max_mm.isApprox(other.max_mm, 1e-4)) << seed;
  }
}

TEST(NciRead, PlungesDrawNothingAndDivideThePasses) {
  const Drawing drawing = Read(File({{0, "0 0 0 5 -2 0"},
                                     {1, "0 0 0 -1 50 0"},
                                     {1, "0 3 0 -1 50 0"},
                                     {1, "0 0 0 -1 50 0"},
                                     {1, "0 0 0 -2 50 0"},
                                     {1, "0 3 0 -2 50 0"},
                                     {1, "0 3 0 9 50 0"}}));
  ASSERT_EQ(drawing.curves.size(), 2U);
  EXPECT_EQ(BeginOf(drawing.curves[1].pieces[0]), Vec3(0, 0, -2));
  const FileFinding plunge = FindingOf(drawing, "plunge");
  EXPECT_EQ(plunge.count, 3U);
  EXPECT_EQ(plunge.where, "line 3");
  EXPECT_EQ(plunge.effect, Effect::kNothingSeen);
}

TEST(NciRead, ToolsAreLayersAndAChangeGivesNoPlace) {
  const Drawing drawing = Read(File({{1001, "0 0 0 12 0 0"},
                                     {0, "0 0 0 0 -2 0"},
                                     {1, "0 1 0 0 50 0"},
                                     {1002, "0 0 0 3 0 0"},
                                     {1, "0 5 0 0 50 0"},
                                     {1, "0 6 0 0 50 0"}}));
  ASSERT_EQ(drawing.curves.size(), 2U);
  EXPECT_EQ(drawing.names.at(drawing.curves[0].layer), "T12");
  EXPECT_EQ(drawing.names.at(drawing.curves[1].layer), "T3");
  EXPECT_EQ(BeginOf(drawing.curves[1].pieces[0]), Vec3(5, 0, 0));
  EXPECT_EQ(FindingOf(drawing, "does not give").where, "line 9");
}

TEST(NciRead, AUnitIsAMillimetreOrAsAskedFor) {
  const std::string text = File({{0, "0 0 0 0 -2 0"}, {3, "0 0 2 0 1 0 0 9 0 0"}});
  ReadOptions inches;
  inches.unit_mm = 25.4;
  EXPECT_NEAR(LengthOf(FlatOf(Read(text)).curves.at(0)), pi, 1e-3);
  const Drawing drawing = Read(text, inches);
  EXPECT_NEAR(LengthOf(FlatOf(drawing).curves.at(0)), 25.4 * pi, 1e-3);
  EXPECT_EQ(drawing.unit_mm, 25.4);
}

TEST(NciRead, WhatIsNotDrawnIsNamedWithItsFirstLineAndNumber) {
  const Drawing drawing = Read(File({{0, "0 1 0 0 -2 0"},
                                     {81, "0 1 1 1"},
                                     {100, "0 1 1 1"},
                                     {777, "anything"},
                                     {777, ""},
                                     {0, "0 1 0 0 -2 0"},
                                     {3, "0 41 -1 0 0 0 5 9 0 0"},
                                     {1, "0 -2 0 5 9 0"},
                                     {11, "1 2 3 4 5 6 7 8 9"},
                                     {1, "0 7 2 3 9 0"},
                                     {1014, "1 0 0 0 0 1 0 -1 0"},
                                     {1018, "1"},
                                     {2, "0 0 7 2 6 2 3 9 0 0"}}));
  const auto expect = [&](const std::string& what, std::uint64_t count,
                          const std::string& where, Effect effect) {
    const FileFinding finding = FindingOf(drawing, what);
    EXPECT_EQ(finding.count, count) << what;
    EXPECT_EQ(finding.where, where) << what;
    EXPECT_EQ(finding.effect, effect) << what;
    EXPECT_FALSE(finding.remedy.empty()) << what;
  };
  expect("drilling cycle (code 81)", 1, "line 3", Effect::kLost);
  expect("drilling cycle (code 100)", 1, "line 5", Effect::kLost);
  expect("unknown code 777", 2, "line 7", Effect::kLost);
  expect("compensation in the control", 1, "line 13", Effect::kChanged);
  expect("z changes", 1, "line 13", Effect::kChanged);
  expect("five-axis", 1, "line 17", Effect::kLost);
  expect("tool plane", 1, "line 21", Effect::kChanged);
  expect("subprogram", 1, "line 23", Effect::kChanged);
  expect("ends where it begins", 1, "line 25", Effect::kLost);
  // The arc lies flat, and what follows it begins at the z where it ended.
  ASSERT_EQ(drawing.curves.size(), 3U);
  EXPECT_EQ(EndOf(drawing.curves[0].pieces[0]).z(), 0);
  EXPECT_EQ(BeginOf(drawing.curves[1].pieces[0]), Vec3(-1, 0, 5));
  EXPECT_EQ(BeginOf(drawing.curves[2].pieces[0]), Vec3(1, 2, 3));
}

TEST(NciRead, AMissingEndAndTextBehindItAreWarnings) {
  const std::vector<Record> line{{0, "0 0 0 0 -2 0"}, {1, "0 1 0 0 9 0"}};
  EXPECT_TRUE(Read(File(line) + "\r\n \x1A\x1A").findings.empty());
  EXPECT_EQ(FindingOf(Read(File(line, false)), "code 1003").where, "line 4");
  const Drawing behind = Read(File(line) + "1\n0 5 5 0 9 0\n");
  EXPECT_EQ(behind.curves.size(), 1U);
  EXPECT_EQ(FindingOf(behind, "text behind the end").count, 1U);
}

TEST(NciRead, AByteOrderMarkIsNoCode) {
  const std::string text = File({{0, "0 0 0 0 0 0"}, {1, "0 8 6 0 100 0"}});
  EXPECT_EQ(FlatOf(Read("\xEF\xBB\xBF" + text)).curves.size(),
            FlatOf(Read(text)).curves.size());
}

TEST(NciRead, ErrorsNameLineValueAndRemedy) {
  EXPECT_THAT(ErrorOf("").message, AllOf(HasSubstr("a.nci"), HasSubstr("not NCI")));
  const Error words = ErrorOf("1050\n9 1\nG1 X5\n");
  EXPECT_EQ(words.code, ErrorCode::kUnreadable);
  EXPECT_THAT(words.message, AllOf(HasSubstr("line 3"), HasSubstr("\"G1 X5\"")));
  EXPECT_THAT(ErrorOf("100000\n\n").message, HasSubstr("0 to 99999"));
  EXPECT_THAT(ErrorOf("-1\n\n").message, HasSubstr("\"-1\""));
  EXPECT_THAT(ErrorOf("0\n0 0 0 0 -2 0\n1\n").message,
              AllOf(HasSubstr("line 3, code 1"), HasSubstr("cut short")));
  const std::string begin = "0\n0 0 0 0 -2 0\n";
  EXPECT_THAT(ErrorOf(begin + "1\n0 1 x 0 9 0\n").message,
              AllOf(HasSubstr("line 3, code 1"), HasSubstr("parameter 3 is \"x\"")));
  EXPECT_THAT(ErrorOf(begin + "1\n0 1 nan 0 9 0\n").message, HasSubstr("\"nan\""));
  EXPECT_THAT(ErrorOf(begin + "1\n0 1 2\n").message, HasSubstr("needs 6"));
  EXPECT_THAT(ErrorOf(begin + "3\n0 0 1 1 0 1 0 9\n").message, HasSubstr("needs 9"));
  EXPECT_THAT(ErrorOf(begin + "1\n43 1 2 0 9 0\n").message, HasSubstr("140"));
  EXPECT_THAT(ErrorOf(begin + "3\n0 0 9 0 1 0 0 9 0 0\n").message,
              AllOf(HasSubstr("begins 1 and ends 8"), HasSubstr("post")));
  EXPECT_THAT(ErrorOf(begin + "3\n0 0 0 0 0 0 0 9 0 0\n").message,
              HasSubstr("begins 0 and ends 0"));
  for (const char* plane : {"1 0", "0 1", "2 0", "0 2", "40 2", "1 41"}) {
    const Error other = ErrorOf(begin + fmt::format("3\n{} 2 0 1 0 0 9 0 0\n", plane));
    EXPECT_EQ(other.code, ErrorCode::kUnsupported) << plane;
    EXPECT_THAT(other.message, HasSubstr("as lines"));
  }
  EXPECT_THAT(ErrorOf("1001\n0 0 0 1.5\n").message, HasSubstr("number of the tool"));
  EXPECT_EQ(ErrorOf(begin + "1\n0 1e12 0 0 9 0\n1003\n\n").code,
            ErrorCode::kInvalidValue);
}

TEST(NciRead, LimitsHold) {
  ReadOptions options;
  options.limits.max_points = 10;
  options.limits.max_entities = 10;
  std::string one_line = "0\n0 0 0 0 -2 0\n", many = one_line, unknown;
  for (int i = 1; i < 12; ++i) {
    one_line += fmt::format("1\n0 {} 0 0 9 0\n", i);
    many += fmt::format("1\n0 {} 0 0 9 0\n0\n0 {} 1 0 -2 0\n", i, i);
    unknown += "700\n\n";
  }
  for (const std::string& text : {one_line, many, unknown})
    EXPECT_EQ(ErrorOf(text, options).code, ErrorCode::kTooLarge);
  options.limits.max_file_bytes = 20;
  EXPECT_THAT(ErrorOf(one_line, options).message, HasSubstr("the limit is 20"));
}

/// The drawing in words, a piece a line.
std::string Written(const Drawing& drawing) {
  std::string text;
  const auto point = [](const Vec3& p) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
  };
  for (const Curve& curve : drawing.curves) {
    text += fmt::format("curve of {}\n", drawing.names.at(curve.layer));
    for (const Piece& piece : curve.pieces) {
      if (const auto* line = std::get_if<Polyline>(&piece)) {
        text += "  line";
        for (const Vec3& p : line->points_mm) text += " " + point(p);
      } else {
        const auto& arc = std::get<EllipticArc>(piece);
        text += fmt::format("  arc {} about {} by {:.2f} deg", point(BeginOf(piece)),
                            point(arc.center_mm), arc.sweep_rad * 180 / pi);
      }
      text += "\n";
    }
  }
  for (const FileFinding& finding : drawing.findings)
    text += fmt::format("{} x {} ({})\n", finding.count, finding.what, finding.where);
  return text;
}

// A plate of two passes, a hole as a full circle, and a drilled one, as a program would
// write it. INTAGLIO_WRITE_GOLDEN=1 writes the golden file anew.
TEST(NciRead, TheSampleIsReadAsItsGolden) {
  const std::string folder = INTAGLIO_SOURCE_DIR "/tests/data/drawings/";
  const Drawing drawing = Read(FileText(folder + "plate.nci"));
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr)
    std::ofstream(folder + "plate_nci.golden", std::ios::binary) << Written(drawing);
  EXPECT_EQ(Written(drawing), FileText(folder + "plate_nci.golden"));
  // By geometry: two outlines of 60 x 40 with corners of 5, and a circle of radius 10.
  const FlatDrawing flat = FlatOf(drawing);
  ASSERT_EQ(flat.curves.size(), 3U);
  EXPECT_NEAR(AreaOf(flat.curves[0]), 60 * 40 - (4 - pi) * 25, 0.05);
  EXPECT_NEAR(AreaOf(flat.curves[1]), 60 * 40 - (4 - pi) * 25, 0.05);
  EXPECT_NEAR(AreaOf(flat.curves[2]), -pi * 100, 0.05);
}

}  // namespace
}  // namespace intaglio::drawing
