#include "engrave/render/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

constexpr int kMarginPx = 24;
constexpr int kHeaderPx = 96;
constexpr int kColumnPx = 446;
constexpr int kPaddingPx = 20;
constexpr int kVerdictPx = 62;
constexpr int kMaxNotesPx = 400;
constexpr double kNoteCapPx = 9.5, kNoteLinePx = 19.0;
constexpr double kLegendCapPx = 9.5, kLegendLinePx = 18.5;

void AddTitle(Page& page, const ViewsCaption& caption) {
  const Palette palette;
  constexpr std::array<double, 3> kBaselines = {46.0, 70.0, 90.0};
  const std::size_t count = std::min(caption.title_lines.size(), kBaselines.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& line = caption.title_lines[i];
    const TextStyle style{.cap_height_px = i == 0 ? 20.0 : 10.5,
                          .color = i == 0 ? palette.text : palette.dim_text,
                          .weight = i == 0 ? 1.2 : 1.0};
    page.lines.push_back(
        {{kMarginPx, kBaselines[i]}, line, FittingStyle(line, style, page.views.width)});
  }
}

/// The column at the right, filled from above and from below.
class Column {
 public:
  Column(Page& page, const Rect& room)
      : page_(page),
        x_(room.x),
        width_(room.width),
        top_(room.y),
        bottom_(room.bottom()) {}

  /// In a frame of its colour.
  void AddVerdict(const std::string& verdict, Tone tone) {
    if (verdict.empty()) return;
    const Color& color = palette_.of(tone);
    const Rect frame{x_, top_, width_, kVerdictPx};
    page_.bars.push_back({frame, {color, 0.10F}});
    page_.bars.push_back({frame, {color, 0.8F}, true});
    const TextStyle style = FittingStyle(
        verdict,
        {.cap_height_px = 18.0, .color = color, .weight = 1.3, .align = Align::kCenter},
        width_ - 2.0 * kPaddingPx);
    page_.lines.push_back(
        {{x_ + 0.5 * width_, top_ + 0.5 * (kVerdictPx + style.cap_height_px)},
         verdict,
         style});
    top_ += kVerdictPx + kCellGapPx;
  }

  /// Sentences with a bar of their colour at the left.
  void AddNotes(const std::vector<Note>& notes) {
    if (notes.empty()) return;
    const std::size_t frame = page_.bars.size();
    page_.bars.emplace_back();
    page_.bars.emplace_back();
    double y = top_ + 14.0;
    const double last = top_ + kMaxNotesPx;
    for (std::size_t i = 0; i < notes.size(); ++i) {
      const auto lines = WrapText(notes[i].text, kNoteCapPx, text_width());
      const bool is_last = i + 1 == notes.size();
      if (i > 0 &&
          y + static_cast<double>(lines.size() + (is_last ? 0 : 1)) * kNoteLinePx >
              last) {
        y = AddNote({fmt::format("and {} more", notes.size() - i)},
                    palette_.of(notes[i].tone), y);
        break;
      }
      y = AddNote(lines, palette_.of(notes[i].tone), y);
    }
    const Rect cell{x_, top_, width_, static_cast<int>(y) - top_ + 4};
    page_.bars[frame] = {cell, {palette_.cell, 0.55F}};
    page_.bars[frame + 1] = {cell, {palette_.cell_frame, 0.9F}, true};
    top_ = cell.bottom() + kCellGapPx;
  }

  /// The rest of the column: the figures, the legend below them.
  void AddFigures(const std::vector<Figure>& figures,
                  const std::vector<LegendEntry>& legend) {
    if (figures.empty() && legend.empty()) return;
    const Rect cell{x_, top_, width_, bottom_ - top_};
    page_.bars.push_back({cell, {palette_.cell, 0.55F}});
    page_.bars.push_back({cell, {palette_.cell_frame, 0.9F}, true});
    page_.lines.push_back(
        {{x_ + kPaddingPx, top_ + 26.0},
         "Figures",
         {.cap_height_px = 11.0, .color = palette_.text, .weight = 1.25}});
    AddRows(figures, top_ + 44.0, AddLegend(legend) - 14.0);
  }

 private:
  double text_width() const { return width_ - 2.0 * kPaddingPx - 8.0; }

  double AddNote(const std::vector<std::string>& lines, const Color& color, double y) {
    const double first = y;
    for (const std::string& line : lines) {
      y += kNoteLinePx;
      page_.lines.push_back({{x_ + kPaddingPx + 8.0, y - 5.0},
                             line,
                             {.cap_height_px = kNoteCapPx, .color = color}});
    }
    page_.bars.push_back(
        {{x_ + 14, static_cast<int>(first) + 2, 3, static_cast<int>(y - first) - 4},
         {color, 0.8F}});
    return y + 8.0;
  }

  /// From below; returns its top.
  double AddLegend(const std::vector<LegendEntry>& legend) {
    const double left = x_ + kPaddingPx;
    double terms_px = 0.0;
    for (const LegendEntry& entry : legend) {
      terms_px = std::max(terms_px, TextWidth(entry.term, kLegendCapPx));
    }
    const double indent = std::min(terms_px + 14.0, 0.4 * width_);
    std::vector<std::vector<std::string>> meanings;
    std::size_t count = 0;
    for (const LegendEntry& entry : legend) {
      meanings.push_back(
          WrapText(entry.meaning, kLegendCapPx, width_ - 2.0 * kPaddingPx - indent));
      count += std::max<std::size_t>(1, meanings.back().size());
    }
    double y = bottom_ - 14.0 - static_cast<double>(count) * kLegendLinePx;
    const double top = y;
    for (std::size_t i = 0; i < legend.size(); ++i) {
      page_.lines.push_back({{left, y + 13.0},
                             legend[i].term,
                             {.cap_height_px = kLegendCapPx, .color = palette_.text}});
      for (const std::string& line : meanings[i]) {
        page_.lines.push_back(
            {{left + indent, y + 13.0},
             line,
             {.cap_height_px = kLegendCapPx, .color = palette_.dim_text}});
        y += kLegendLinePx;
      }
    }
    return top;
  }

  void AddRows(const std::vector<Figure>& figures, double top, double bottom) {
    if (figures.empty()) return;
    const double row_px =
        std::min(34.0, (bottom - top) / static_cast<double>(figures.size()));
    const double cap_px = std::clamp(0.36 * row_px, 5.0, 11.0);
    const double left = x_ + kPaddingPx, right = x_ + width_ - kPaddingPx;
    for (const Figure& figure : figures) {
      const double baseline = top + 0.5 * (row_px + cap_px);
      page_.lines.push_back({{left, baseline},
                             figure.label,
                             {.cap_height_px = cap_px, .color = palette_.dim_text}});
      const TextStyle style{.cap_height_px = cap_px,
                            .color = palette_.of(figure.tone),
                            .weight = 1.15,
                            .align = Align::kRight};
      const double room = right - left - TextWidth(figure.label, cap_px) - 16.0;
      page_.lines.push_back(
          {{right, baseline}, figure.value, FittingStyle(figure.value, style, room)});
      top += row_px;
      if (&figure == &figures.back()) break;
      page_.bars.push_back({{static_cast<int>(left), static_cast<int>(top),
                             static_cast<int>(right - left), 1},
                            {palette_.cell_frame, 0.6F}});
    }
  }

  Page& page_;
  Palette palette_;
  int x_, width_, top_, bottom_;
};

void DrawGround(Canvas& canvas) {
  const Palette palette;
  for (int y = 0; y < canvas.height(); ++y) {
    const float t = static_cast<float>(y) / static_cast<float>(canvas.height());
    const Color color = Mix(palette.background_top, palette.background_bottom, t);
    for (int x = 0; x < canvas.width(); ++x) canvas.at(x, y) = color;
  }
}

}  // namespace

Page LayOutPage(const ViewsCaption& caption) {
  Page page;
  const bool has_column = !caption.verdict.empty() || !caption.notes.empty() ||
                          !caption.figures.empty() || !caption.legend.empty();
  const int views_right = has_column ? kViewsWidth - kMarginPx - kColumnPx - kCellGapPx
                                     : kViewsWidth - kMarginPx;
  const int top = kHeaderPx + kCellGapPx;
  page.views = {kMarginPx, top, views_right - kMarginPx, kViewsHeight - kMarginPx - top};
  AddTitle(page, caption);
  Column column(page, {views_right + kCellGapPx, kMarginPx, kColumnPx,
                       kViewsHeight - 2 * kMarginPx});
  column.AddVerdict(caption.verdict, caption.verdict_tone);
  column.AddNotes(caption.notes);
  column.AddFigures(caption.figures, caption.legend);
  return page;
}

void DrawPage(Canvas& canvas, const Page& page) {
  DrawGround(canvas);
  for (const Bar& bar : page.bars) {
    if (bar.outline) {
      FrameRect(canvas, bar.rect, bar.paint);
    } else {
      FillRect(canvas, bar.rect, bar.paint);
    }
  }
  for (const TextLine& line : page.lines) {
    DrawText(canvas, line.at_px, line.text, line.style);
  }
}

}  // namespace intaglio::render
