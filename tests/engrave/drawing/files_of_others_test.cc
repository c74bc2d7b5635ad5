// Drawings of the kinds that people reported with other programs. The files are our own;
// their bounding boxes are computed from the standards (SVG 1.1, DXF reference, HP-GL/2),
// and were checked with Chromium, ezdxf and hp2xx: tests/data/README.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "engrave/drawing/dxf/dxf_encoding.h"
#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/hpgl_read.h"
#include "engrave/drawing/svg/svg_read.h"
#include "engrave/io/whole_file.h"

namespace intaglio::drawing {
namespace {

std::string BytesOf(const std::string& name) {
  const auto bytes = io::ReadWholeFile(INTAGLIO_SOURCE_DIR "/tests/data/kinds/" + name,
                                       std::uint64_t{1} << 20);
  EXPECT_TRUE(bytes) << name;
  return bytes ? *bytes : std::string();
}

Drawing ReadFile(const std::string& name) {
  const std::string text = BytesOf(name);
  const auto read = name.ends_with(".svg")   ? ReadSvg(text, {}, name)
                    : name.ends_with(".dxf") ? ReadDxf(text, {}, name)
                                             : ReadHpgl(text, {}, name);
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read ? *read : Drawing();
}

Box3 BoundsOf(const Drawing& drawing) {
  Box3 box;
  const auto flat = Flatten(drawing);
  EXPECT_TRUE(flat);
  for (const FlatCurve& curve : flat->curves) {
    for (const Vec3& p : curve.points_mm) box.Extend(p);
  }
  return box;
}

struct Expected {
  const char* file;
  double x0, y0, x1, y1;
};

class FilesOfOthers : public ::testing::TestWithParam<Expected> {};

TEST_P(FilesOfOthers, HaveTheBoundsOfTheirStandard) {
  const Expected& expected = GetParam();
  const Box3 box = BoundsOf(ReadFile(expected.file));
  // Chords of 1 um, and numbers of a file with two decimals.
  EXPECT_NEAR(box.min_mm.x(), expected.x0, 0.01);
  EXPECT_NEAR(box.min_mm.y(), expected.y0, 0.01);
  EXPECT_NEAR(box.max_mm.x(), expected.x1, 0.01);
  EXPECT_NEAR(box.max_mm.y(), expected.y1, 0.01);
}

// The picture of an icon is 24 px = 6.35 mm (frame.svg), or 16 px = 4.233 mm (em.svg).
INSTANTIATE_TEST_SUITE_P(
    Drawings, FilesOfOthers,
    ::testing::Values(
        Expected{"clip.svg", 20, 15, 40, 35}, Expected{"viewport.svg", 15, 20, 30, 35},
        Expected{"css_transform.svg", 40, 10, 60, 30},
        Expected{"origin.svg", 45, 15, 55, 35}, Expected{"css_size.svg", 2, 10, 60, 48},
        Expected{"use_size.svg", 10, 20, 30, 40}, Expected{"switch.svg", 20, 40, 30, 50},
        Expected{"entity.svg", 10, 20, 70, 40},
        Expected{"em.svg", 0.352778, 0.352778, 3.880556, 3.880556},
        Expected{"frame.svg", 1.5875, 1.5875, 4.7625, 4.7625},
        Expected{"flat_scale.dxf", 0, 0, 30, 25}, Expected{"name_case.dxf", 0, 0, 30, 25},
        Expected{"point_circle.dxf", 0, 0, 5, 0}, Expected{"label.plt", 0, 0, 30, 10},
        Expected{"arcs.plt", 0, 0, 13.75, 10}, Expected{"rotate.plt", 0, 0, 0, 20},
        Expected{"encoded.plt", 0, 0, 30, 10}));

TEST(FilesOfOthers, OnLayer0OfABlockIsTheLayerOfItsInsertion) {
  Drawing drawing = ReadFile("block_layer.dxf");
  std::erase_if(drawing.curves, [&](const Curve& curve) {
    return drawing.names.at(curve.layer) != "CUT";
  });
  const Box3 box = BoundsOf(drawing);
  EXPECT_EQ(box.size_mm().x(), 30);
  EXPECT_EQ(box.size_mm().y(), 25);
}

TEST(FilesOfOthers, LayersAreReadByTheCodePage) {
  const Drawing drawing = ReadFile("code_page.dxf");
  ASSERT_EQ(drawing.curves.size(), 1U);
  EXPECT_EQ(drawing.names.at(drawing.curves[0].layer), "Fr\xC3\xA4sen");
}

TEST(FilesOfOthers, WhatIsNotMadeIsAWarningByName) {
  EXPECT_EQ(ReadFile("point_circle.dxf").findings.CountOf("CIRCLE without a radius"), 1U);
  EXPECT_EQ(ReadFile("label.plt").findings.CountOf("LB"), 1U);
}

/// A group of a binary DXF of release 13 and later.
std::string Binary(int code, const std::string& text) {
  std::string group{static_cast<char>(code & 0xFF), static_cast<char>(code >> 8)};
  return group + text + '\0';
}
std::string Binary(int code, double number) {
  std::string group{static_cast<char>(code & 0xFF), static_cast<char>(code >> 8)};
  return group.append(reinterpret_cast<const char*>(&number), sizeof number);
}

TEST(FilesOfOthers, ABinaryDxfIsReadAsItsText) {
  const std::string binary = std::string("AutoCAD Binary DXF\r\n\x1A\0", 22) +
                             Binary(0, "SECTION") + Binary(2, "ENTITIES") +
                             Binary(0, "LINE") + Binary(8, "cut") + Binary(10, 1.5) +
                             Binary(20, 0.1) + Binary(11, 4.0) + Binary(21, -2e-3) +
                             Binary(0, "ENDSEC") + Binary(0, "EOF");
  const auto drawing = ReadDxf(binary);
  ASSERT_TRUE(drawing) << drawing.error().message;
  ASSERT_EQ(drawing->curves.size(), 1U);
  EXPECT_EQ(std::get<Polyline>(drawing->curves[0].pieces[0]).points_mm,
            (PointList{{1.5, 0.1, 0}, {4, -2e-3, 0}}));
  // Without the group EOF, which programs leave out, it is whole.
  const std::size_t end = binary.size() - Binary(0, "EOF").size();
  for (std::size_t size = 22; size < binary.size(); ++size) {
    if (size == end) continue;
    const auto cut = ReadDxf(binary.substr(0, size));
    EXPECT_FALSE(cut.has_value()) << size;
  }
}

TEST(FilesOfOthers, MasksMarkersAndPatternsAreNamedWithTheirArea) {
  const auto drawing = ReadSvg(
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='50mm' "
      "viewBox='0 0 100 50'><mask id='m'/><pattern id='p'/><marker id='k'/>"
      "<g style='mask: url(#m)'><rect width='10' height='20'/></g>"
      "<rect width='3' height='3' fill='url(#p)'/>"
      "<path d='M0 0h5' stroke='red' marker-end='url(#k)'/></svg>");
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing->curves.size(), 3U);
  ASSERT_EQ(drawing->findings.size(), 3U);
  EXPECT_NEAR(drawing->findings.begin()->area_mm2, 200, 1e-6);
  for (const char* name : {"mask", "pattern", "marker"})
    EXPECT_EQ(drawing->findings.CountOf(name), 1U) << name;
  for (const Warning& warning : WarningsOf("a.svg", drawing->findings))
    EXPECT_EQ(warning.weight, WarningWeight::kWarning);
}

std::vector<std::string> FoundIn(const Drawing& drawing) {
  std::vector<std::string> names;
  for (const FileFinding& finding : drawing.findings) names.push_back(finding.what);
  return names;
}

Drawing ReadRectangle(const std::string& css, const std::string& before = {}) {
  const auto drawing = ReadSvg(
      before +
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='50mm' viewBox='0 0 "
      "100 50'><g style='" +
      css + "'><rect x='10' y='10' width='20' height='10' stroke='red'/></g></svg>");
  EXPECT_TRUE(drawing) << css << (drawing ? "" : drawing.error().message);
  return drawing.value_or(Drawing());
}

// Browsers move, size and dash the rectangle by each of these.
TEST(FilesOfOthers, PropertiesThatMoveAShapeAreObeyedOrNamed) {
  for (const auto& [css, name] :
       {std::pair("translate: 10px 10px", "translate"),
        std::pair("rotate: 30deg", "rotate"), std::pair("scale: 2", "scale"),
        std::pair("zoom: 2", "zoom"),
        std::pair("offset-path: path(\"M0 0H50\")", "offset-path"),
        std::pair("transform: rotate(9deg);transform-box: "
                  "fill-box",
                  "transform-box"),
        std::pair("stroke-dasharray: 2 1", "stroke-dasharray")}) {
    const Drawing drawing = ReadRectangle(css);
    EXPECT_EQ(FoundIn(drawing), std::vector<std::string>{name}) << css;
    for (const FileFinding& finding : drawing.findings)
      EXPECT_EQ(finding.effect, Effect::kChanged) << css;
    EXPECT_EQ(drawing.curves.size(), 1U) << css;
  }
  for (const char* css : {"translate: none", "scale: 1", "rotate: 0", "zoom: 100%",
                          "transform-box: fill-box", "stroke-dasharray: none",
                          "transform: scale(1);transform-box: view-box"})
    EXPECT_TRUE(ReadRectangle(css).findings.empty()) << css;
}

TEST(FilesOfOthers, WhatIsFullyTransparentIsInvisible) {
  for (const char* css : {"opacity: 0", "opacity: 0.0%", "display: none"}) {
    const Drawing drawing = ReadRectangle(css);
    EXPECT_TRUE(drawing.curves.empty()) << css;
    EXPECT_EQ(FoundIn(drawing), std::vector<std::string>{"invisible"}) << css;
  }
  EXPECT_EQ(ReadRectangle("opacity: 0.01").curves.size(), 1U);
  const auto drawing = ReadSvg(
      "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'><path d='M0 0h1'"
      " fill-opacity='0' stroke='red' stroke-opacity='0'/><path d='M0 0h1' stroke='red'"
      " fill-opacity='0'/></svg>");
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->curves.size(), 1U);
}

TEST(FilesOfOthers, AStyleSheetOfAnotherFileIsNamed) {
  EXPECT_EQ(
      FoundIn(ReadRectangle("", "<?xml version='1.0'?><?xml-stylesheet href='a.css'?>")),
      std::vector<std::string>{"style sheet of another file"});
}

// hp2xx draws the line with the pen alone, also behind an IN.
TEST(FilesOfOthers, NoPenDrawsNothing) {
  const auto drawing = ReadHpgl(
      "IN;SP1;PU0,0;PD400,0;SP0;PU0,0;PD0,400;IN;PU0,0;PD0,800;SP2;PD40,800;PU;");
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing->curves.size(), 2U);
  EXPECT_EQ(drawing->findings.CountOf("line without a pen (SP0)"), 2U);
}

// The arcs of three points, by points on them; hp2xx draws the same.
TEST(FilesOfOthers, ArcsThroughThreePointsPassThem) {
  const auto drawing =
      ReadHpgl("IN;PU400,0;PD;AT0,400,-400,0;PU;PU0,0;PD;RT40,40,80,0;PU;");
  ASSERT_TRUE(drawing) << drawing.error().message;
  const Box3 box = BoundsOf(*drawing);
  EXPECT_NEAR(box.max_mm.y(), 10, 1e-3);
  EXPECT_NEAR(box.min_mm.x(), -10, 1e-3);
  EXPECT_NEAR(box.min_mm.y(), 0, 1e-9);
}

}  // namespace
}  // namespace intaglio::drawing
