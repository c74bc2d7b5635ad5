// A step is at work when the laser is on, or when the tip of a spindle is in the sheet.
// The plan is the marks' own way: of a spindle pass k of n at depth k / n, of a laser n
// times through the sheet. Both are swept over cells; the plan twice, by its radius more
// and less the tolerance, so that nothing counts which is a matter of the tolerance.
//
// Of each place of a mark the tool's visits are counted in plan and record alike: marks
// that share a way are told apart by their number alone. The deviations d of the places
// along their normals u are a shift s of the whole mark, sum u (u.d) = (sum u u^T) s, and
// its shape, d - u.s.

#include "engrave/proof/cut_comparison.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/proof/way_index.h"

namespace intaglio::proof {
namespace {

constexpr double kChord_mm = 0.001;
constexpr double kPlaces_mm = 0.2;  // along a mark
constexpr double kNear_mm = 0.05;   // farther away it is another way
constexpr double kFace_mm = 1e-3;   // above it nothing is cut
constexpr double kCell_mm = 0.02;
constexpr double kManyCells = 8e6;
constexpr double kMinCellsOfTool = 3;
constexpr double kIncomplete = 0.1;  // as mark_comparison.h

struct MarkPlace {
  Vec2 at_mm = Vec2::Zero(), normal = Vec2::Zero();
};

std::vector<Vec2> ChordsOf(const mark::Mark& mark) {
  std::vector<Vec2> way = mark::PlacesOf(mark, kChord_mm);
  if (mark.closed && way.size() > 1) way.push_back(way.front());
  return way;
}

std::vector<MarkPlace> PlacesAlong(const mark::Mark& mark) {
  const std::vector<Vec2> way = ChordsOf(mark);
  std::vector<MarkPlace> places;
  double total_mm = 0, done_mm = 0;
  for (std::size_t i = 1; i < way.size(); ++i) total_mm += (way[i] - way[i - 1]).norm();
  const double spacing_mm = std::min(kPlaces_mm, total_mm / 8);
  double next_mm = spacing_mm / 2;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Vec2 chord = way[i] - way[i - 1];
    const double length_mm = chord.norm();
    if (!(length_mm > 0)) continue;
    const Vec2 normal = Vec2(-chord.y(), chord.x()) / length_mm;
    for (; next_mm < done_mm + length_mm; next_mm += spacing_mm)
      places.push_back({way[i - 1] + chord * (next_mm - done_mm) / length_mm, normal});
    done_mm += length_mm;
  }
  if (places.empty()) places.push_back({way.front(), Vec2::Zero()});
  return places;
}

/// How deep pass `pass` of a pen is, of 1 .. pass_count.
double DepthOf(const mark::Pen& pen, std::uint32_t pass,
               const formats::ToolWayHeader& of) {
  return of.is_laser ? of.sheet_thickness_mm : pen.depth_mm * pass / pen.pass_count;
}

std::vector<CutStep> PlannedSteps(const mark::MarkSet& set,
                                  const formats::ToolWayHeader& header) {
  std::vector<CutStep> steps;
  const auto at = [](const Vec2& place, double depth_mm) {
    return Vec3(place.x(), place.y(), -depth_mm);
  };
  for (const mark::Mark& mark : set.marks) {
    const mark::Pen& pen = set.pens[mark.pen];
    const std::vector<Vec2> way = ChordsOf(mark);
    for (std::uint32_t pass = 1; pass <= pen.pass_count; ++pass) {
      const double depth_mm = DepthOf(pen, pass, header);
      // A pass is a visit of its own: an empty step divides it from the one before.
      steps.push_back({at(way.front(), -1), at(way.front(), -1)});
      if (way.size() == 1)
        steps.push_back({at(way.front(), depth_mm), at(way.front(), depth_mm)});
      for (std::size_t i = 1; i < way.size(); ++i)
        steps.push_back({at(way[i - 1], depth_mm), at(way[i], depth_mm)});
    }
  }
  return steps;
}

/// Of the record: what is at work, z below the face; others as empty steps above it.
struct RecordedSteps {
  std::vector<CutStep> steps;
  double idle_in_sheet_mm = 0, work_s = 0;
};

RecordedSteps StepsOfRecord(const formats::ToolWay& way) {
  RecordedSteps recorded;
  Vec3 from_mm = Vec3::Zero();
  std::uint64_t from_us = 0, first_us = 0, last_us = 0;
  for (const formats::ToolWayStep& step : way.steps) {
    const Vec3 face(0, 0, way.header.sheet_height_mm);
    CutStep cut{from_mm - face, step.end_mm - face};
    const double lowest_mm = std::min(cut.from_mm.z(), cut.to_mm.z());
    const bool in_sheet = !way.header.is_laser && lowest_mm < -kFace_mm;
    const bool works = way.header.is_laser ? step.is_on : in_sheet;
    if (in_sheet && !step.is_on)
      recorded.idle_in_sheet_mm += (cut.to_mm - cut.from_mm).norm();
    if (works && way.header.is_laser)
      cut.from_mm.z() = cut.to_mm.z() = -way.header.sheet_thickness_mm;
    if (!works) cut.from_mm.z() = cut.to_mm.z() = 1;
    if (works && last_us == 0) first_us = from_us;
    if (works) last_us = step.end_us;
    recorded.steps.push_back(cut);
    from_mm = step.end_mm;
    from_us = step.end_us;
  }
  recorded.work_s = 1e-6 * static_cast<double>(last_us - first_us);
  return recorded;
}

class MarkJudge {
 public:
  MarkJudge(const mark::MarkSet& set, const formats::ToolWayHeader& header,
            const WayIndex& planned, const WayIndex& recorded)
      : set_(set), header_(header), planned_(planned), recorded_(recorded) {}

  BurntMark Judge(const mark::Mark& mark) const {
    const mark::Pen& pen = set_.pens[mark.pen];
    const std::vector<MarkPlace> places = PlacesAlong(mark);
    BurntMark judged;
    std::vector<double> made;  // of its passes, at each place
    double sum = 0;
    for (const MarkPlace& place : places) {
      made.push_back(PassesAt(place.at_mm, pen));
      sum += std::min<double>(made.back(), pen.pass_count);
    }
    judged.pass_count = sum / static_cast<double>(places.size());
    const auto middle = made.begin() + static_cast<std::ptrdiff_t>(made.size() / 2);
    std::nth_element(made.begin(), middle, made.end());
    judged.fate = FateOf(judged.pass_count, *middle, pen.pass_count);
    if (judged.fate == BurntFate::kDoubled) judged.pass_count = *middle;
    Measure(places, DepthOf(pen, pen.pass_count, header_), judged);
    return judged;
  }

 private:
  /// What other marks need of the visits is not this mark's.
  double PassesAt(const Vec2& place_mm, const mark::Pen& pen) const {
    std::set<double> depths;
    for (std::uint32_t pass = 1; pass <= pen.pass_count; ++pass)
      depths.insert(DepthOf(pen, pass, header_));
    double visits = 0, planned = 0;
    for (const double depth_mm : depths) {
      visits += static_cast<double>(recorded_.VisitsOf(place_mm, depth_mm, kNear_mm));
      planned += static_cast<double>(planned_.VisitsOf(place_mm, depth_mm, kNear_mm));
    }
    return std::max(0.0, visits - (planned - pen.pass_count));
  }
  static BurntFate FateOf(double passes, double median, double wanted) {
    if (passes == 0) return BurntFate::kMissed;
    if (median >= wanted + 1) return BurntFate::kDoubled;
    const double lack = std::min(kIncomplete * wanted, 0.5);
    return passes < wanted - lack ? BurntFate::kIncomplete : BurntFate::kMade;
  }
  void Measure(const std::vector<MarkPlace>& places, double depth_mm,
               BurntMark& judged) const {
    Eigen::Matrix2d normals = Eigen::Matrix2d::Identity() * 1e-9;
    Vec2 sum = Vec2::Zero();
    std::vector<std::pair<Vec2, double>> deviations;
    for (const MarkPlace& place : places) {
      const auto to = recorded_.ToNearest(place.at_mm, depth_mm, kNear_mm);
      if (!to) continue;
      if (place.normal == Vec2::Zero()) {
        judged.offset_mm = *to;
        continue;
      }
      const double off_mm = place.normal.dot(*to);
      normals += place.normal * place.normal.transpose();
      sum += off_mm * place.normal;
      deviations.emplace_back(place.normal, off_mm);
    }
    if (deviations.empty()) return;
    judged.offset_mm = normals.ldlt().solve(sum);
    for (const auto& [normal, off_mm] : deviations) {
      judged.shape_um = std::max(judged.shape_um,
                                 1e3 * std::abs(off_mm - normal.dot(judged.offset_mm)));
    }
  }

  const mark::MarkSet& set_;
  const formats::ToolWayHeader& header_;
  const WayIndex &planned_, &recorded_;
};

void CountMarks(MarkComparison& comparison) {
  for (const BurntMark& mark : comparison.marks) {
    switch (mark.fate) {
      case BurntFate::kMissed:
        ++comparison.missed_count;
        break;
      case BurntFate::kIncomplete:
        ++comparison.incomplete_count;
        break;
      case BurntFate::kDoubled:
        ++comparison.doubled_count;
        break;
      case BurntFate::kMade:
        ++comparison.made_count;
        comparison.worst.place_um =
            std::max(comparison.worst.place_um, 1e3 * mark.offset_mm.norm());
        comparison.worst.shape_um = std::max(comparison.worst.shape_um, mark.shape_um);
    }
  }
}

struct Sheets {
  CutSheet wide, narrow, cut;  ///< planned, by more and by less; and as it is
};

Result<Sheets> SweepAll(std::span<const CutStep> planned, const CutPlan& plan,
                        std::span<const CutStep> recorded, double diameter_mm) {
  Vec2 min = Vec2::Constant(1e9), max = -min;
  for (const auto steps : {planned, recorded}) {
    for (const CutStep& step : steps) {
      if (std::min(step.from_mm.z(), step.to_mm.z()) >= 0) continue;
      for (const Vec3& at : {step.from_mm, step.to_mm}) {
        min = min.cwiseMin(at.head<2>());
        max = max.cwiseMax(at.head<2>());
      }
    }
  }
  if (min.x() > max.x()) min = max = Vec2::Zero();
  // Around it all is one piece.
  const double edge_mm = std::max(plan.tool_diameter_mm, diameter_mm) + 1;
  min.array() -= edge_mm;
  max.array() += edge_mm;
  const double finest_mm = std::max(kCell_mm, std::sqrt((max - min).prod() / kManyCells));
  const double cell_mm =
      std::min(finest_mm, std::min(plan.tool_diameter_mm, diameter_mm) / kMinCellsOfTool);
  const CutSheet empty = INTAGLIO_TRY(CutSheet::Make(min, max, cell_mm));
  Sheets sheets{empty, empty, empty};
  for (const CutStep& step : planned) {
    sheets.wide.Sweep(step, plan.tool_diameter_mm / 2 + plan.tolerance_mm);
    sheets.narrow.Sweep(step, std::max(plan.tool_diameter_mm / 4,
                                       plan.tool_diameter_mm / 2 - plan.tolerance_mm));
  }
  for (const CutStep& step : recorded) sheets.cut.Sweep(step, diameter_mm / 2);
  return sheets;
}

void CompareDepths(const Sheets& sheets, double thickness_mm, const CutPlan& plan,
                   CutFigures& figures) {
  const double thickness_um = 1e3 * thickness_mm, tolerance_um = 1e3 * plan.tolerance_mm;
  std::uint64_t cleared = 0, beside = 0, uncut = 0, deep = 0, through = 0;
  double deepest_um = 0;
  for (std::size_t i = 0; i < sheets.cut.size(); ++i) {
    const double is_um = sheets.cut.depth_um(i), wide_um = sheets.wide.depth_um(i),
                 narrow_um = sheets.narrow.depth_um(i);
    cleared += is_um > 0;
    deepest_um = std::max(deepest_um, is_um);
    beside += is_um > 0 && wide_um == 0;
    uncut += is_um + tolerance_um < narrow_um;
    deep += wide_um > 0 && is_um > wide_um + tolerance_um;
    const bool may_be_through =
        plan.may_cut_through && wide_um >= thickness_um - tolerance_um;
    through += is_um >= thickness_um && !may_be_through;
  }
  const double cell_mm2 = sheets.cut.cell_mm() * sheets.cut.cell_mm();
  figures.cleared_mm2 = cell_mm2 * static_cast<double>(cleared);
  figures.beside_mm2 = cell_mm2 * static_cast<double>(beside);
  figures.uncut_mm2 = cell_mm2 * static_cast<double>(uncut);
  figures.too_deep_mm2 = cell_mm2 * static_cast<double>(deep);
  figures.through_mm2 = cell_mm2 * static_cast<double>(through);
  figures.deepest_mm = deepest_um / 1e3;
}

/// By the pieces of the sheet that the widest plan leaves: each is surely of one piece.
void ComparePieces(const Sheets& sheets, CutFigures& figures) {
  const auto sure = PiecesOf(sheets.wide), planned = PiecesOf(sheets.narrow),
             left = PiecesOf(sheets.cut);
  std::map<std::uint32_t, std::set<std::uint32_t>> left_of, planned_of;
  for (std::size_t i = 0; i < sure.size(); ++i) {
    if (sure[i] == 0) continue;
    auto& pieces = left_of[planned[i]];
    if (left[i] == 0) continue;
    pieces.insert(left[i]);
    planned_of[left[i]].insert(planned[i]);
  }
  figures.pieces_planned = static_cast<std::uint32_t>(left_of.size());
  figures.pieces_left = static_cast<std::uint32_t>(planned_of.size());
  std::set<std::uint32_t> joined;
  for (const auto& [piece, several] : planned_of)
    if (several.size() > 1) joined.insert(several.begin(), several.end());
  figures.pieces_joined = static_cast<std::uint32_t>(joined.size());
  for (const auto& [piece, several] : left_of) figures.pieces_split += several.size() > 1;
}

double StrayOf(std::span<const CutStep> recorded, const WayIndex& planned) {
  double stray_mm = 0;
  for (const CutStep& step : recorded) {
    if (std::min(step.from_mm.z(), step.to_mm.z()) >= 0) continue;
    const Vec2 middle = (step.from_mm + step.to_mm).head<2>() / 2;
    const double depth_mm = -std::min(step.from_mm.z(), step.to_mm.z());
    const bool upright = (step.to_mm - step.from_mm).head<2>().norm() < kNear_mm;
    if (upright ? planned.ReachesTo(middle, depth_mm, kNear_mm)
                : planned.ToNearest(middle, depth_mm, kNear_mm).has_value())
      continue;
    stray_mm += (step.to_mm - step.from_mm).norm();
  }
  return stray_mm;
}

}  // namespace

Result<CutComparison> CompareCuts(const mark::MarkSet& set, const CutPlan& plan,
                                  const formats::ToolWay& way) {
  const std::vector<CutStep> planned = PlannedSteps(set, way.header);
  RecordedSteps recorded = StepsOfRecord(way);
  Sheets sheets =
      INTAGLIO_TRY(SweepAll(planned, plan, recorded.steps, way.header.tool_diameter_mm));
  CutFigures figures;
  figures.cell_mm = sheets.cut.cell_mm();
  figures.idle_in_sheet_mm = recorded.idle_in_sheet_mm;
  figures.work_s = recorded.work_s;
  CompareDepths(sheets, way.header.sheet_thickness_mm, plan, figures);
  ComparePieces(sheets, figures);
  const WayIndex planned_index(planned), recorded_index(recorded.steps);
  figures.stray_mm = StrayOf(recorded.steps, planned_index);
  MarkComparison marks;
  const MarkJudge judge(set, way.header, planned_index, recorded_index);
  for (const mark::Mark& mark : set.marks) marks.marks.push_back(judge.Judge(mark));
  CountMarks(marks);
  return CutComparison{std::move(marks), figures, std::move(sheets.cut),
                       std::move(recorded.steps)};
}

}  // namespace intaglio::proof
