#include "services/job/marks/timed_mark.h"

#include <algorithm>

#include "services/job/machine/head_ticks.h"

namespace intaglio {
namespace {

constexpr double kArcToleranceMm = 0.001;

Vec2 OnWeb(const mark::Mark& mark, const mark::Place& place) {
  return place.at_mm - Vec2(mark.web_mm, 0);
}

bool HasArcs(const mark::Mark& mark) {
  return std::ranges::any_of(mark.places,
                             [](const mark::Place& p) { return p.bulge != 0; });
}

MarkExtent ExtentOfPlaces(std::span<const Vec2> places_mm, const mark::Pen& pen,
                          const HeadFigures& head) {
  MarkExtent extent{};
  extent.min_mm = extent.max_mm = places_mm.front();
  for (const Vec2& p : places_mm) {
    extent.min_mm = extent.min_mm.cwiseMin(p);
    extent.max_mm = extent.max_mm.cwiseMax(p);
  }
  extent.made_at = head.window.Displacements(places_mm, kWebBorderMm + LeadMm(pen, head));
  return extent;
}

}  // namespace

MarkExtent ExtentOf(const mark::Mark& mark, const mark::Pen& pen,
                    const HeadFigures& head) {
  std::vector<Vec2> places_mm = mark::PlacesOf(mark, kArcToleranceMm);
  for (Vec2& p : places_mm) p.x() -= mark.web_mm;
  return ExtentOfPlaces(places_mm, pen, head);
}

MeasuredMark Measure(const mark::Mark& mark, const mark::Pen& pen,
                     const HeadFigures& head) {
  MeasuredMark measured;
  const std::vector<galvo::MarkStroke> strokes = StrokesOf(mark, pen);
  // Chords of arcs are finer for ticks.
  measured.extent = HasArcs(mark) ? ExtentOf(mark, pen, head)
                                  : ExtentOfPlaces(strokes.front().points_mm, pen, head);
  measured.start.begin_mm = OnWeb(mark, mark.places.front());
  measured.end_mm = OnWeb(mark, mark.closed ? mark.places.front() : mark.places.back());
  const double length_mm = mark::LengthOf(mark);
  measured.length_mm = pen.pass_count * mark::LitLengthOf(mark);
  galvo::MarkTickOptions ticks = head.ticks;
  ticks.mark_mm_s = pen.speed_mm_s;
  MarkStart& start = measured.start;
  if (const auto counted = galvo::CountStrokeTicks(strokes, ticks)) {
    start.ticks = *counted;
    start.rest_mm = counted->end_mm;
  } else {
    start.time_s = pen.pass_count * length_mm / pen.speed_mm_s;
    start.rest_mm = measured.end_mm;
  }
  return measured;
}

std::vector<MeasuredMark> MeasureAll(std::span<const mark::Mark> marks,
                                     std::span<const mark::Pen> pens,
                                     const HeadFigures& head) {
  std::vector<MeasuredMark> measured;
  measured.reserve(marks.size());
  for (const mark::Mark& mark : marks)
    measured.push_back(Measure(mark, pens[mark.pen], head));
  return measured;
}

double TimeFrom(const Vec2& from_mm, const MarkStart& start, const HeadFigures& head) {
  if (!start.ticks) return start.time_s;
  const Vec2 way_mm = from_mm - start.begin_mm;
  const double within = std::min(1.0, head.field_mm() / std::max(way_mm.norm(), 1e-9));
  const Vec2 jump_mm = start.ticks->first_mm - (start.begin_mm + within * way_mm);
  const std::size_t count =
      galvo::CountJumpTicks(jump_mm.norm(), head.ticks) + start.ticks->count;
  return static_cast<double>(count) / head.ticks.rate_hz;
}

double JumpMm(const Vec2& from_mm, const MarkStart& start, const HeadFigures& head) {
  return std::min((start.begin_mm - from_mm).norm(), head.field_mm());
}

galvo::TimedMark TimedBy(const galvo::Span& made_at, const HeadFigures& head,
                         double time_s) {
  // A mark without an extent is made in the whole field, but for the last digit.
  const double extent_mm = std::max(0.0, head.web_field_mm() - made_at.width_mm());
  return {(made_at.from_mm + made_at.to_mm) / 2, extent_mm, time_s};
}

double LeadMm(const mark::Pen& pen, const HeadFigures& head) {
  return head.ticks.lead_servo ? head.ticks.lag_s * pen.speed_mm_s : 0;
}

}  // namespace intaglio
