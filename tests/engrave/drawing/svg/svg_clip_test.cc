#include "engrave/drawing/svg/svg_clip.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>

#include "engrave/core/segment.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/svg/svg_read.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

/// 100 x 100 mm, a user unit is a millimetre; `clipped` refers to the clip path c.
Drawing Clipped(const std::string& defs, const std::string& clipped) {
  auto drawing = ReadSvg(
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='100mm' "
      "viewBox='0 0 100 100'><defs>" +
      defs + "</defs>" + clipped + "</svg>");
  EXPECT_TRUE(drawing) << drawing.error().message;
  return drawing ? *drawing : Drawing{};
}

/// Whether a place of the file, y down, is in an odd number of the closed curves.
bool IsIn(const FlatDrawing& flat, double x, double y_down) {
  const double y = 100 - y_down;
  bool inside = false;
  for (const FlatCurve& curve : flat.curves) {
    if (!curve.closed) continue;
    const std::size_t n = curve.points_mm.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 &p = curve.points_mm[i], &q = curve.points_mm[(i + 1) % n];
      if ((p.y() <= y) == (q.y() <= y)) continue;
      if (p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()) > x) inside = !inside;
    }
  }
  return inside;
}

/// Compares a grid of places; they lie off round numbers. Chromium 156 draws the same:
/// its pictures of these files differ from what is read at edges alone.
void ExpectInside(const Drawing& drawing, const std::function<bool(double, double)>& in) {
  EXPECT_EQ(drawing.findings.CountOf("clip-path"), 0U);
  const auto flat = Flatten(drawing);
  ASSERT_TRUE(flat);
  for (double x = 0.37; x < 100; x += 2.5) {
    for (double y = 0.41; y < 100; y += 2.5) {
      ASSERT_EQ(IsIn(*flat, x, y), in(x, y)) << x << ", " << y;
    }
  }
}

bool InBox(double x, double y, double left, double top, double right, double bottom) {
  return left < x && x < right && top < y && y < bottom;
}
bool InCircle(double x, double y, double cx, double cy, double r) {
  return (x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r;
}

const char kPlate[] = "<rect x='5' y='5' width='90' height='90' clip-path='url(#c)'/>";

TEST(SvgClip, ShapesThatAreNotConvexAreCut) {
  // A letter L.
  ExpectInside(
      Clipped("<clipPath id='c'><path d='M10 10H40V60H80V90H10Z'/></clipPath>", kPlate),
      [](double x, double y) {
        return InBox(x, y, 10, 10, 40, 90) || InBox(x, y, 10, 60, 80, 90);
      });
}

TEST(SvgClip, SeveralShapesAreUnited) {
  ExpectInside(Clipped("<clipPath id='c'><circle cx='30' cy='40' r='22'/><title>a</title>"
                       "<circle cx='50' cy='40' r='22'/><rect x='70' y='70' width='60' "
                       "height='10'/></clipPath>",
                       kPlate),
               [](double x, double y) {
                 return InCircle(x, y, 30, 40, 22) || InCircle(x, y, 50, 40, 22) ||
                        InBox(x, y, 70, 70, 95, 80);
               });
}

// The square within the square runs in the same direction.
TEST(SvgClip, TheRuleDecidesOnHoles) {
  const std::string squares = "d='M10 10H90V90H10ZM30 30H70V70H30Z'/></clipPath>";
  const auto ring = [](double x, double y) {
    return InBox(x, y, 10, 10, 90, 90) && !InBox(x, y, 30, 30, 70, 70);
  };
  const auto square = [](double x, double y) { return InBox(x, y, 10, 10, 90, 90); };
  const std::string begin = "<clipPath id='c'><path ";
  ExpectInside(Clipped(begin + squares, kPlate), square);
  ExpectInside(Clipped(begin + "clip-rule='evenodd' " + squares, kPlate), ring);
  ExpectInside(Clipped(begin + "style='clip-rule:evenodd' " + squares, kPlate), ring);
  ExpectInside(
      Clipped("<g clip-rule='evenodd'><clipPath id='c'><path " + squares + "</g>",
              kPlate),
      ring);
  ExpectInside(
      Clipped("<clipPath id='c' clip-rule='evenodd'><path clip-rule='nonzero' " + squares,
              kPlate),
      square);
  // fill-rule is of what is drawn, and the rule of what is clipped has no effect.
  ExpectInside(Clipped(begin + "fill-rule='evenodd' " + squares,
                       "<g clip-rule='evenodd'>" + std::string(kPlate) + "</g>"),
               square);
}

TEST(SvgClip, ClipsAreClippedThemselves) {
  const std::string half = "<clipPath id='h'><rect width='50' height='100'/></clipPath>";
  const auto in_half = [](double x, double y) {
    return x < 50 && InCircle(x, y, 50, 50, 40);
  };
  ExpectInside(Clipped(half + "<clipPath id='c' clip-path='url(#h)'><circle cx='50' "
                              "cy='50' r='40'/></clipPath>",
                       kPlate),
               in_half);
  ExpectInside(Clipped(half + "<clipPath id='c'><circle cx='50' cy='50' r='40' "
                              "clip-path='url(#h)'/></clipPath>",
                       kPlate),
               in_half);
  // One shape is clipped, the other is not.
  ExpectInside(
      Clipped(half + "<clipPath id='c'><circle cx='50' cy='50' r='40' "
                     "clip-path='url(#h)'/><rect x='60' y='20' width='20' height='20'/>"
                     "</clipPath>",
              kPlate),
      [&](double x, double y) { return in_half(x, y) || InBox(x, y, 60, 20, 80, 40); });
  // Its transform moves the clip path, and not its own clip.
  ExpectInside(Clipped(half + "<clipPath id='c' clip-path='url(#h)' "
                              "transform='translate(20 0)'><circle cx='50' cy='50' "
                              "r='40'/></clipPath>",
                       kPlate),
               [](double x, double y) { return x < 50 && InCircle(x, y, 70, 50, 40); });
  // Groups in groups.
  ExpectInside(Clipped(half + "<clipPath id='c'><circle cx='50' cy='50' r='40'/>"
                              "</clipPath>",
                       "<g clip-path='url(#h)'>" + std::string(kPlate) + "</g>"),
               in_half);
}

// Units of the box of what is clipped: a shape, a group, a use; without its own
// transform, and with what is not drawn itself.
TEST(SvgClip, ClipsInUnitsOfTheBox) {
  const std::string clip =
      "<clipPath id='c' clipPathUnits='objectBoundingBox'><path d='M0 0H1V.5H.5V1H0Z'/>"
      "<rect x='.75' y='.75' width='.25' height='.25'/>"
      // A share of the page, in units of the box: far outside.
      "<rect x='25%' width='1' height='1'/></clipPath>";
  const auto corner = [](double x, double y, double left, double top, double w,
                         double h) {
    return InBox(x, y, left, top, left + w, top + h / 2) ||
           InBox(x, y, left, top, left + w / 2, top + h) ||
           InBox(x, y, left + 0.75 * w, top + 0.75 * h, left + w, top + h);
  };
  ExpectInside(Clipped(clip, kPlate),
               [&](double x, double y) { return corner(x, y, 5, 5, 90, 90); });
  const std::string group =
      "<rect x='10' y='20' width='30' height='20'/><g transform='translate(10 10)'>"
      "<rect x='50' y='50' width='20' height='20' visibility='hidden'/></g>";
  const auto of_group = [&](double x, double y) {
    return InBox(x, y, 10, 20, 40, 40) && corner(x, y, 10, 20, 70, 60);
  };
  ExpectInside(Clipped(clip, "<g clip-path='url(#c)'>" + group + "</g>"), of_group);
  ExpectInside(Clipped(clip + "<g id='g'>" + group + "</g>",
                       "<use href='#g' clip-path='url(#c)'/>"),
               of_group);
  ExpectInside(Clipped(clip,
                       "<rect x='0' y='0' width='30' height='20' clip-path='url(#c)' "
                       "transform='translate(20 30) scale(2)'/>"),
               [&](double x, double y) { return corner(x, y, 20, 30, 60, 40); });
}

// A transform is around the units of the box.
TEST(SvgClip, ATransformOfAClipInUnitsOfTheBox) {
  ExpectInside(Clipped("<clipPath id='c' clipPathUnits='objectBoundingBox' "
                       "transform='scale(.5)'><rect x='.2' y='.2' width='1.2' "
                       "height='.9'/></clipPath>",
                       kPlate),
               [](double x, double y) { return InBox(x, y, 11.5, 11.5, 65.5, 52); });
}

// The place of a use is the end of its transform, so that its clip moves with it.
TEST(SvgClip, UsesAreClippedAtTheirPlace) {
  const std::string defs =
      "<clipPath id='h'><rect width='50' height='100'/></clipPath>"
      "<path id='l' d='M0 0H90V30H0Z'/>";
  const auto in = [](double x, double y) { return InBox(x, y, 5, 15, 55, 45); };
  const std::string use = "<use href='#l' x='5' y='15' clip-path='url(#h)'/>";
  ExpectInside(Clipped(defs, use), in);
  ExpectInside(Clipped(defs + "<clipPath id='c'>" + use + "</clipPath>", kPlate), in);
}

TEST(SvgClip, UsesAndTransformsWithinClips) {
  ExpectInside(
      Clipped("<path id='l' d='M0 0H30V10H10V30H0Z'/><clipPath id='c' "
              "transform='translate(20 10)'><use href='#l' x='5' y='5'/><use href='#l' "
              "transform='rotate(180 25 25)'/></clipPath>",
              kPlate),
      [](double x, double y) {
        const auto in_l = [](double u, double v) {
          return InBox(u, v, 0, 0, 30, 10) || InBox(u, v, 0, 0, 10, 30);
        };
        return in_l(x - 25, y - 15) || in_l(50 - (x - 20), 50 - (y - 10));
      });
}

TEST(SvgClip, WhatIsNotShownClipsNothing) {
  ExpectInside(
      Clipped("<clipPath id='c'><rect width='20' height='90' display='none'/><rect "
              "width='30' height='90' visibility='hidden'/><g><rect width='90' "
              "height='90'/></g><rect x='40' width='20' height='90' fill='none' "
              "opacity='0'/></clipPath>",
              kPlate),
      [](double x, double y) { return InBox(x, y, 40, 5, 60, 90); });
  EXPECT_TRUE(Clipped("<clipPath id='c'/>", kPlate).curves.empty());
}

// Lines without a fill are cut where they cross the outlines, and stay open.
TEST(SvgClip, LinesAreCutIntoPieces) {
  const Drawing drawing = Clipped(
      "<clipPath id='c'><path clip-rule='evenodd' d='M10 10H90V90H10ZM30 30H70V70H30Z'/>"
      "</clipPath>",
      "<g clip-path='url(#c)' fill='none' stroke='red'><path d='M0 50H100'/>"
      "<circle cx='50' cy='50' r='30'/></g>");
  const auto flat = Flatten(drawing);
  ASSERT_TRUE(flat);
  ASSERT_EQ(flat->curves.size(), 3U);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(LengthOf(flat->curves[i]), 20, 1e-9);
    EXPECT_EQ(drawing.names[drawing.curves[i].color], "red");
  }
  // The circle of radius 30 is outside of the hole and stays as it is.
  EXPECT_TRUE(std::holds_alternative<EllipticArc>(drawing.curves[2].pieces[0]));
}

// What is not cut is a warning with its area, and is made as a whole.
TEST(SvgClip, ClipsThatAreNotReadAreWarnedOf) {
  const std::string defs[] = {
      "<clipPath id='c'><text>a</text></clipPath>",
      "<clipPath id='c'><rect width='9' height='9' style='rotate: 20deg'/></clipPath>",
      "<clipPath id='c' clip-path='url(#c)'><rect width='9' height='9'/></clipPath>",
      "<clipPath id='d'><text>a</text></clipPath><clipPath id='c'><rect width='9' "
      "height='9' clip-path='url(#d)'/></clipPath>",
      "<rect id='c' width='9' height='9'/>"};
  for (const std::string& def : defs) {
    const Drawing drawing = Clipped(def, kPlate);
    ASSERT_EQ(drawing.findings.size(), 1U) << def;
    const FileFinding& finding = *drawing.findings.begin();
    EXPECT_EQ(finding.what, "clip-path") << def;
    EXPECT_EQ(finding.effect, Effect::kChanged) << def;
    EXPECT_NEAR(finding.area_mm2, 8100, 1) << def;
    EXPECT_EQ(drawing.curves.size(), 1U) << def;
  }
  EXPECT_EQ(Clipped("", "<rect width='9' height='9' clip-path='circle(3px)'/>")
                .findings.CountOf("clip-path"),
            1U);
}

TEST(SvgClip, AClipOfManyEdgesIsCutInTime) {
  std::string star = "<clipPath id='c'><path d='M";
  constexpr int kCorners = 8000;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kCorners;
    const double radius = i % 2 == 0 ? 45 : 44.99;
    star += fmt::format("{:.6f} {:.6f} ", 50 + radius * std::cos(angle),
                        50 + radius * std::sin(angle));
  }
  star += "Z'/></clipPath>";
  std::string boxes = "<g clip-path='url(#c)'>";
  for (int i = 0; i < 2500; ++i)
    boxes += fmt::format("<rect x='{}' y='{}' width='1' height='1' clip-path='url(#c)'/>",
                         i % 50 * 2, i / 50 * 2);
  const auto begin = std::chrono::steady_clock::now();
  const Drawing drawing = Clipped(star, boxes + "</g>");
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(drawing.findings.size(), 0U);
  EXPECT_GT(drawing.curves.size(), 1500U);
  // All pairs of edges, 2500 x 2 x 4 x 8000, would take far longer.
  EXPECT_LT(taken.count(), 20);
}

}  // namespace
}  // namespace intaglio::drawing
