// Debian's gerbv draws the same layers: the area and the extents of its picture have to
// be those of the elements that are read.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "engrave/contour/files/gerber_read.h"
#include "engrave/contour/files/kicad_read.h"
#include "engrave/contour/region/region.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/image/image_file.h"
#include "tests/engrave/contour/files/kicad_text.h"
#include "tests/test_folder.h"

namespace intaglio::contour {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

// 0.025 mm, of which the widths of the boards are multiples: gerbv rounds to pixels.
constexpr int kPixelsPerInch = 1016;
constexpr double kPixel_mm = 25.4 / kPixelsPerInch;

bool IsGerbvInstalled() {
  return std::system("command -v gerbv > /dev/null 2>&1") ==
         0;  // NOLINT(concurrency-mt-unsafe)
}

std::string PlaceOf(const Vec2& p) {
  return fmt::format("X{}Y{}", std::llround(p.x() * 1e6), std::llround(p.y() * 1e6));
}

/// A layer in RS-274X: outlines first, their holes as clear regions.
class LayerText {
 public:
  explicit LayerText(const std::vector<Element>& elements) {
    for (const Element& element : elements) {
      if (const auto* outline = std::get_if<Outline>(&element.shape)) Write(*outline);
    }
    for (const Element& element : elements) std::visit(*this, element.shape);
  }
  std::string Text() const {
    return "%FSLAX46Y46*%\n%MOMM*%\n" + apertures_ + "%LPD*%\nG01*\nG75*\n" + body_ +
           "M02*\n";
  }

  void operator()(const Circle& s) { Flash("C," + Size(s.diameter_mm), s.center_mm); }
  void operator()(const Square& s) {
    Flash("R," + Size(s.side_mm) + "X" + Size(s.side_mm), s.center_mm);
  }
  void operator()(const Octagon& s) {
    Flash(fmt::format("P,{}X8X22.5", Size(s.size_mm / std::cos(pi / 8))), s.center_mm);
  }
  void operator()(const Track& s) {
    Select("C," + Size(s.width_mm));
    Draw(MakeLine(s.begin_mm, s.end_mm), true);
  }
  void operator()(const ArcTrack& s) {
    Select("C," + Size(s.width_mm));
    Draw(s.arc, true);
  }
  void operator()(const Outline&) {}

 private:
  static std::string Size(double size) { return fmt::format("{:.6f}", size); }
  void Select(const std::string& aperture) {
    apertures_ += fmt::format("%ADD{}{}*%\n", number_, aperture);
    body_ += fmt::format("D{}*\n", number_++);
  }
  void Flash(const std::string& aperture, const Vec2& place) {
    Select(aperture);
    body_ += PlaceOf(place) + "D03*\n";
  }
  void Draw(const Edge& edge, bool moves) {
    if (moves) body_ += PlaceOf(edge.begin_mm) + "D02*\n";
    if (!edge.is_arc()) {
      body_ += "G01" + PlaceOf(edge.end_mm) + "D01*\n";
      return;
    }
    const Vec2 to_center = edge.center_mm - edge.begin_mm;
    body_ += fmt::format("{}{}I{}J{}D01*\n", edge.sweep_rad > 0 ? "G03" : "G02",
                         PlaceOf(edge.end_mm), std::llround(to_center.x() * 1e6),
                         std::llround(to_center.y() * 1e6));
  }
  void Write(const Outline& outline) {
    const auto region = RegionOfLoops(outline.loops);
    ASSERT_TRUE(region) << region.error().message;
    for (const bool hole : {false, true}) {
      for (const Edges& loop : region->loops) {
        if ((AreaOf(loop) < 0) != hole) continue;
        body_ += hole ? "%LPC*%\nG36*\n" : "%LPD*%\nG36*\n";
        for (std::size_t k = 0; k < loop.size(); ++k) Draw(loop[k], k == 0);
        body_ += "G37*\n";
      }
    }
    body_ += "%LPD*%\n";
  }

  std::string apertures_;
  std::string body_;
  int number_ = 10;
};

struct Drawn {
  double area_mm2 = 0;
  Vec2 sides_mm = Vec2::Zero();
};

/// Black on white. With a margin of 3 %: gerbv finds the extents of regions by their
/// corners and would cut off arcs.
Drawn DrawnByGerbv(const std::string& layer) {
  const fs::path folder = intaglio::test::FreshFolder();
  const fs::path file = folder / "layer.gbr";
  std::ofstream(file) << layer;
  const std::string command = fmt::format(
      "gerbv -x png -D {} -B 3 -a -b '#FFFFFF' -f '#000000FF' -o {} {} > {} 2>&1",
      kPixelsPerInch, (folder / "layer.png").string(), file.string(),
      (folder / "gerbv.log").string());
  EXPECT_EQ(std::system(command.c_str()), 0)  // NOLINT(concurrency-mt-unsafe)
      << intaglio::test::ContentOf(folder / "gerbv.log");
  image::ImageOptions options;
  options.samples = image::Samples::kAsStored;
  const auto picture =
      image::ParseImage(intaglio::test::ContentOf(folder / "layer.png"), options);
  EXPECT_TRUE(picture) << picture.error().message;
  Drawn drawn;
  if (!picture) return drawn;
  double black = 0;
  int right = -1;
  int left = picture->width;
  int bottom = -1;
  int top = picture->height;
  for (int y = 0; y < picture->height; ++y) {
    for (int x = 0; x < picture->width; ++x) {
      const double part = 1 - picture->at(x, y) / 65535.0;
      black += part;
      if (part < 0.5) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  drawn.area_mm2 = black * kPixel_mm * kPixel_mm;
  drawn.sides_mm = kPixel_mm * Vec2(right - left + 1, bottom - top + 1);
  return drawn;
}

Drawn DrawnByUs(const std::string& layer) {
  const auto elements = ReadGerber(layer, "layer.gbr");
  EXPECT_TRUE(elements) << elements.error().message;
  const auto united = Unite(*elements, {0, Corners::kRound});
  EXPECT_TRUE(united) << united.error().message;
  Drawn drawn{united->area_mm2, Vec2::Zero()};
  Vec2 low = Vec2::Constant(1e300);
  Vec2 high = -low;
  for (const Contour& contour : united->contours) {
    for (const Edge& edge : contour.edges) {
      for (int k = 0; k <= 32; ++k) {
        const Vec2 p = PointAt(edge, k / 32.0 * edge.length_mm);
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
  }
  drawn.sides_mm = high - low;
  return drawn;
}

/// Two pixels for the extents, which gerbv rounds at both ends; arcs and slopes are right
/// in the mean.
void ExpectAlike(const std::string& layer) {
  const Drawn judge = DrawnByGerbv(layer);
  const Drawn ours = DrawnByUs(layer);
  EXPECT_NEAR(ours.area_mm2 / judge.area_mm2, 1, 2e-3);
  EXPECT_NEAR(ours.sides_mm.x(), judge.sides_mm.x(), 2.5 * kPixel_mm);
  EXPECT_NEAR(ours.sides_mm.y(), judge.sides_mm.y(), 2.5 * kPixel_mm);
}

TEST(GerberJudge, GerbvDrawsTheSameBoards) {
  if (!IsGerbvInstalled()) GTEST_SKIP() << "no gerbv: install the package gerbv";
  for (const test::KicadText& text :
       {test::LadderBoard(), test::FanBoard(), test::PlaneBoard()}) {
    const auto board = ReadKicadBoard(text.Text(), "a.kicad_pcb");
    ASSERT_TRUE(board) << board.error().message;
    for (const std::uint32_t layer : {0U, 1U}) {
      SCOPED_TRACE(board->elements[0].element.name + " " + board->layers[layer]);
      ExpectAlike(LayerText(ElementsOfLayer(*board, layer)).Text());
      if (HasFailure()) return;  // the folder of the test has the layer and its picture
    }
  }
}

TEST(GerberJudge, GerbvClearsTheSame) {
  if (!IsGerbvInstalled()) GTEST_SKIP() << "no gerbv: install the package gerbv";
  const std::string begin =
      "%FSLAX46Y46*%\n%MOMM*%\n%ADD10R,10X10*%\n%ADD11C,4*%\n%ADD12C,2*%\n%ADD13C,1*%\n"
      "%ADD14C,6X2*%\n%LPD*%\nG01*\nG75*\n";
  ExpectAlike(begin +
              "D10*\nX0Y0D03*\n%LPC*%\nD11*\nX1000000Y0D03*\n%LPD*%\nD12*\n"
              "X0Y1000000D03*\n%LPC*%\nD13*\nX-8000000Y-3000000D02*\nX8000000D01*\n"
              "M02*\n");
  ExpectAlike(begin +
              "D10*\nX0Y0D03*\nX20000000D03*\n%LPC*%\nG36*\nX3000000Y3000000D02*\n"
              "X23000000D01*\nY4000000D01*\nX3000000D01*\nY3000000D01*\nG37*\n"
              "M02*\n");
  ExpectAlike(
      "%FSLAX46Y46*%\n%MOMM*%\n%AMHOLED*21,1,4,4,0,0,0*1,0,2,0,0*1,1,1,0,0*%\n%"
      "ADD10HOLED*%"
      "\n%LPD*%\nD10*\nX0Y0D03*\nX5000000D03*\nM02*\n");
  ExpectAlike(begin +
              "%SRX3Y2I12.0J13.0*%\nD10*\nX0Y0D03*\n%LPC*%\nD11*\nX0Y0D03*\n%LPD*%"
              "\nD12*\nX0Y0D03*\n%SR*%\nM02*\n");
}

}  // namespace
}  // namespace intaglio::contour
