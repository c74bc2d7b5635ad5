#include "engrave/render/views_layout.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

const Vec3 kLaidOutBlock(60, 40, 50);

/// A grid of points of this size around a place.
PointList Grid(const Vec3& center_mm, const Vec3& size_mm) {
  PointList points;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) {
      for (int k = 0; k <= 4; ++k) {
        const Vec3 share(i / 4.0 - 0.5, j / 4.0 - 0.5, k / 4.0 - 0.5);
        points.push_back(center_mm + share.cwiseProduct(size_mm));
      }
    }
  }
  return points;
}

ViewsCaption FullCaption() {
  ViewsCaption caption;
  caption.title_lines = {"bunny", "job 7, 2026-11-23 08:12 UTC", "els-03"};
  caption.verdict = "GOOD, WITH WARNINGS";
  caption.verdict_tone = Tone::kWarning;
  caption.notes = {
      {"Measured in the glass.", Tone::kPlain},
      {"the surface is open along 223 edges; fill the holes in a mesh editor "
       "if they are not intended",
       Tone::kWarning}};
  caption.figures = {{"points planned", "20 000"}, {"stray", "0", Tone::kGood}};
  caption.legend = {{"stray", "a crack where no point is planned"},
                    {"doubled", "a point with more than one crack"}};
  return caption;
}

const TextLine* Find(const Page& page, const std::string& text) {
  const auto found =
      std::find_if(page.lines.begin(), page.lines.end(),
                   [&](const TextLine& line) { return line.text.starts_with(text); });
  return found == page.lines.end() ? nullptr : &*found;
}

std::string AllLines(const Page& page) {
  std::string all;
  for (const TextLine& line : page.lines) all += line.text + "\n";
  return all;
}

/// Where the text is drawn.
double LeftOf(const TextLine& line) {
  const double width = TextWidth(line.text, line.style.cap_height_px);
  return line.at_px.x() - (line.style.align == Align::kRight    ? width
                           : line.style.align == Align::kCenter ? width / 2
                                                                : 0);
}
double RightOf(const TextLine& line) {
  return LeftOf(line) + TextWidth(line.text, line.style.cap_height_px);
}

bool Overlap(const Rect& a, const Rect& b) {
  return a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom();
}

TEST(ViewsLayout, WorkInAPlaneHasOneLargePanelFromWhereItIsRead) {
  const Vec3 middle = 0.5 * kLaidOutBlock;
  const struct {
    Vec3 size_mm;
    PanelKind kind;
  } cases[] = {{{40, 0, 20}, PanelKind::kFromFront},
               {{40, 1.1, 20}, PanelKind::kFromFront},  // of two layers
               {{40, 20, 0}, PanelKind::kFromAbove},
               {{0, 30, 20}, PanelKind::kFromRight}};
  for (const auto& [size_mm, kind] : cases) {
    const ViewsLayout layout =
        LayOutViews(Grid(middle, size_mm), kLaidOutBlock, FullCaption());
    ASSERT_EQ(layout.panels.size(), 1u);
    EXPECT_EQ(layout.panels[0].kind, kind);
    EXPECT_TRUE(layout.panels[0].whole_block);
    // Nothing but the panel is in the room for views.
    EXPECT_EQ(layout.panels[0].cell.width, layout.page.views.width);
    EXPECT_EQ(layout.panels[0].cell.height, layout.page.views.height);
  }
}

TEST(ViewsLayout, AReliefIsNoPlane) {
  EXPECT_FALSE(FlatAxis(Grid(0.5 * kLaidOutBlock, {40, 2, 30})).has_value());
  EXPECT_FALSE(FlatAxis({}).has_value());
  EXPECT_FALSE(FlatAxis({Vec3(1, 2, 3)}).has_value());
  EXPECT_FALSE(FlatAxis({Vec3(1, 2, 3), Vec3(1, 2, 3)}).has_value());
  // A line is read from the front.
  EXPECT_EQ(FlatAxis({Vec3(1, 2, 3), Vec3(9, 2, 3)}), 1);
}

TEST(ViewsLayout, ASolidHasAPerspectiveViewLargerThanTheOthersAndNothingOverlaps) {
  for (const Vec3& block : {Vec3(60, 40, 50), Vec3(30, 30, 120), Vec3(120, 80, 20),
                            Vec3(300, 5, 5), Vec3(50, 50, 50)}) {
    const ViewsLayout layout =
        LayOutViews(Grid(0.5 * block, 0.8 * block), block, FullCaption());
    const auto& panels = layout.panels;
    ASSERT_EQ(panels.size(), 4u);
    EXPECT_EQ(panels[0].kind, PanelKind::kPerspective);
    for (std::size_t i = 0; i < panels.size(); ++i) {
      const Rect& cell = panels[i].cell;
      EXPECT_LE(cell.width * cell.height, panels[0].cell.width * panels[0].cell.height);
      EXPECT_GE(cell.x, layout.page.views.x);
      EXPECT_GE(cell.y, layout.page.views.y);
      EXPECT_LE(cell.right(), layout.page.views.right());
      EXPECT_LE(cell.bottom(), layout.page.views.bottom());
      EXPECT_EQ(panels[i].px_per_mm, panels[1].px_per_mm);
      for (std::size_t k = 0; k < i; ++k) EXPECT_FALSE(Overlap(cell, panels[k].cell));
    }
  }
}

TEST(ViewsLayout, SmallWorkIsShownLarge) {
  const Vec3 block(200, 200, 100);
  const PointList small = Grid({150, 50, 30}, {20, 15, 25});
  const ViewsLayout solid = LayOutViews(small, block, FullCaption());
  EXPECT_FALSE(solid.panels[0].whole_block);
  for (const Vec3& p : small) EXPECT_TRUE(solid.panels[0].shown_mm.Contains(p));
  EXPECT_LT(solid.panels[0].shown_mm.size_mm().maxCoeff(), 50);
  // Where it is in the block, the other views show.
  EXPECT_TRUE(solid.panels[1].whole_block);

  const PointList flat = Grid({195, 50, 30}, {8, 0, 4});
  const ViewsLayout drawing = LayOutViews(flat, block, FullCaption());
  ASSERT_EQ(drawing.panels.size(), 1u);
  const Panel& panel = drawing.panels[0];
  for (const Vec3& p : flat) EXPECT_TRUE(panel.shown_mm.Contains(p));
  EXPECT_LT(panel.shown_mm.size_mm().x(), 12);
  EXPECT_GE(panel.shown_mm.min_mm.minCoeff(), 0);
  EXPECT_LE(panel.shown_mm.max_mm.x(), block.x());
  EXPECT_NE(panel.description.find("200 x 100 mm"), std::string::npos);
}

TEST(ViewsLayout, EverythingOfTheCaptionIsWrittenInsideThePicture) {
  const ViewsCaption caption = FullCaption();
  const Page page = LayOutPage(caption);
  for (const char* text :
       {"bunny", "job 7, 2026-11-23 08:12 UTC", "els-03", "GOOD, WITH WARNINGS",
        "Measured in the glass.", "points planned", "20 000", "stray", "doubled",
        "a crack where no point is planned"}) {
    EXPECT_NE(Find(page, text), nullptr) << text;
  }
  for (const TextLine& line : page.lines) {
    EXPECT_GE(LeftOf(line), 0) << line.text;
    EXPECT_LE(RightOf(line), kViewsWidth) << line.text;
    EXPECT_LE(line.at_px.y(), kViewsHeight) << line.text;
  }
  // The warning is beside the verdict: below it, above the figures, in its colour.
  const TextLine* verdict = Find(page, "GOOD, WITH WARNINGS");
  const TextLine* warning = Find(page, "the surface is open");
  const TextLine* figures = Find(page, "Figures");
  ASSERT_NE(warning, nullptr) << AllLines(page);
  EXPECT_GT(warning->at_px.y(), verdict->at_px.y());
  EXPECT_LT(warning->at_px.y(), figures->at_px.y());
  EXPECT_EQ(warning->style.color.r, verdict->style.color.r);
  EXPECT_GT(LeftOf(*warning), page.views.right());
}

TEST(ViewsLayout, LinesOfOneColumnDoNotCoverEachOther) {
  ViewsCaption caption = FullCaption();
  caption.notes.assign(40, {std::string(300, 'w') + " a warning", Tone::kWarning});
  caption.figures.assign(16, {"a figure", "12.3456 mm", Tone::kGood});
  const Page page = LayOutPage(caption);
  std::vector<double> baselines;
  for (const TextLine& line : page.lines) {
    if (LeftOf(line) > page.views.right() && line.style.align == Align::kLeft) {
      baselines.push_back(line.at_px.y());
    }
  }
  std::sort(baselines.begin(), baselines.end());
  // Term and meaning of the legend share a baseline.
  for (std::size_t i = 1; i < baselines.size(); ++i) {
    const double step = baselines[i] - baselines[i - 1];
    EXPECT_TRUE(step == 0 || step > 9) << baselines[i];
  }
  // What does not fit is counted.
  EXPECT_TRUE(std::any_of(page.lines.begin(), page.lines.end(), [](const TextLine& line) {
    return line.text.starts_with("and ") && line.text.ends_with(" more");
  }));
}

TEST(ViewsLayout, WithoutAVerdictAndFiguresTheViewsTakeTheWholeWidth) {
  EXPECT_GT(LayOutPage({}).views.right(), kViewsWidth - 30);
}

TEST(ViewsLayout, ACameraHasOneLargeViewOfThePartAboutTheWork) {
  const Vec3 block(60, 60, 80);
  const PointList work = {Vec3(10, 10, 10), Vec3(20, 20, 20)};
  ViewsOptions options;
  options.camera = Camera{.azimuth_rad = 1, .elevation_rad = 0.5, .zoom = 4};
  options.camera->roll_rad = 0.5;
  options.object_frame = true;
  options.grid_step_mm = 2.5;
  const ViewsLayout layout = LayOutViews(work, block, FullCaption(), options);
  ASSERT_EQ(layout.panels.size(), 1U);
  const Panel& panel = layout.panels[0];
  EXPECT_EQ(panel.kind, PanelKind::kPerspective);
  EXPECT_TRUE(panel.shown_mm.size_mm().isApprox(block / 4, 1e-12));
  EXPECT_TRUE(panel.shown_mm.center_mm().isApprox(Vec3(15, 15, 15), 1e-12));
  EXPECT_EQ(panel.grid_step_mm, 2.5);
  ASSERT_TRUE(panel.work_mm);
  EXPECT_EQ(panel.work_mm->max_mm, Vec3(20, 20, 20));
  EXPECT_TRUE(panel.description.starts_with(
      "azimuth 57°, elevation 29°, roll 29°, 4 times enlarged"))
      << panel.description;
  // Near a wall the part stays within the block; unzoomed it is the block.
  const ViewsLayout wall = LayOutViews({Vec3(1, 1, 79)}, block, FullCaption(), options);
  EXPECT_TRUE(wall.panels[0].shown_mm.min_mm.isApprox(Vec3(0, 0, 60), 1e-12));
  // Shifted by hand.
  options.camera->middle_mm = Vec3(30, 40, 50);
  const Panel shifted = LayOutViews(work, block, FullCaption(), options).panels[0];
  EXPECT_TRUE(shifted.shown_mm.center_mm().isApprox(Vec3(30, 40, 50), 1e-12));
  EXPECT_TRUE(shifted.shown_mm.size_mm().isApprox(block / 4, 1e-12));
  EXPECT_NE(shifted.description.find("4 times enlarged about (30, 40, 50) mm"),
            std::string::npos)
      << shifted.description;
  options.camera->middle_mm = std::nullopt;
  options.camera->zoom = 1;
  EXPECT_TRUE(LayOutViews(work, block, FullCaption(), options).panels[0].whole_block);
  EXPECT_GT(LayOutViews(work, block, FullCaption()).panels.size(), 1U);
}

// A bar of a round length beside it is the oracle of the scale: what the picture draws.
TEST(ViewsLayout, AViewNamesItsGridAndItsScale) {
  const Vec3 block(60, 60, 80);
  const PointList work = {Vec3(10, 10, 10), Vec3(50, 20, 60), Vec3(30, 50, 30)};
  ViewsOptions options;
  options.grid_step_mm = 2.5;
  for (const Panel& panel : LayOutViews(work, block, FullCaption(), options).panels) {
    EXPECT_TRUE(StatusOf(panel).starts_with("grid 2.5 mm, ")) << StatusOf(panel);
    if (panel.kind == PanelKind::kPerspective) {
      EXPECT_NE(StatusOf(panel).find("about"), std::string::npos);
      continue;
    }
    const OrthographicView view = ViewOf(panel.kind);
    const double width_px = panel.px_per_mm * block[view.right_axis];
    EXPECT_LE(width_px, panel.cell.width);
    EXPECT_NE(StatusOf(panel).find(fmt::format("{:.3g} pixels a mm", panel.px_per_mm)),
              std::string::npos)
        << StatusOf(panel);
  }
  // Without a step of its own a view has as many lines as are drawn: 10 to 30 or so.
  for (const Panel& panel : LayOutViews(work, block, FullCaption()).panels) {
    EXPECT_GT(80 / GridStepOf(panel), 5) << StatusOf(panel);
    EXPECT_LT(80 / GridStepOf(panel), 200) << StatusOf(panel);
  }
}

}  // namespace
}  // namespace intaglio::render
