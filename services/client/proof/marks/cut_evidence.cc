#include "services/client/proof/marks/cut_evidence.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio::client {

double ToolDiameterOf(const Course& course) {
  return course.drill_diameter_mm() > 0 ? course.drill_diameter_mm()
                                        : course.tool_diameter_mm();
}

Result<CutEvidence> ReadCutEvidence(const std::filesystem::path& folder,
                                    const Course& course, const mark::MarkSet& marks,
                                    double tolerance_um) {
  const std::filesystem::path file = folder / kCutFile;
  formats::ToolWay way = INTAGLIO_TRY(formats::ReadToolWay(file));
  if (way.torn_bytes > 0) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: cut or damaged behind {}; run the job again",
                            file.string(), Counted(way.steps.size(), "step")),
                file.string());
  }
  const double diameter_mm = ToolDiameterOf(course);
  const bool isolates =
      course.make() == COURSE_MAKE_ISOLATION && !(course.drill_diameter_mm() > 0);
  auto compared = INTAGLIO_TRY(
      proof::CompareCuts(marks, {diameter_mm, !isolates, 1e-3 * tolerance_um}, way));
  return CutEvidence{std::move(way), diameter_mm, std::move(compared)};
}

CutReport CutReportOf(const CutEvidence& evidence) {
  const proof::CutFigures& figures = evidence.compared.figures;
  CutReport cut;
  cut.set_laser(evidence.way.header.is_laser);
  cut.set_tool_diameter_mm(evidence.way.header.tool_diameter_mm);
  cut.set_planned_diameter_mm(evidence.planned_diameter_mm);
  cut.set_sheet_thickness_mm(evidence.way.header.sheet_thickness_mm);
  cut.set_cell_um(1e3 * figures.cell_mm);
  cut.set_pieces_planned(figures.pieces_planned);
  cut.set_pieces_left(figures.pieces_left);
  cut.set_pieces_joined(figures.pieces_joined);
  cut.set_pieces_split(figures.pieces_split);
  cut.set_cleared_mm2(figures.cleared_mm2);
  cut.set_beside_mm2(figures.beside_mm2);
  cut.set_uncut_mm2(figures.uncut_mm2);
  cut.set_too_deep_mm2(figures.too_deep_mm2);
  cut.set_through_mm2(figures.through_mm2);
  cut.set_deepest_mm(figures.deepest_mm);
  cut.set_stray_mm(figures.stray_mm);
  cut.set_idle_in_sheet_mm(figures.idle_in_sheet_mm);
  return cut;
}

void AddCutFaults(const CutReport& cut, Verdict& verdict) {
  const auto none = [&](double figure, const char* sentence) {
    if (figure > 0) verdict.add_reasons(fmt::format(fmt::runtime(sentence), figure));
  };
  if (cut.pieces_left() != cut.pieces_planned()) {
    verdict.add_reasons(fmt::format(
        "{} of the face {} left, {} {} planned", Counted(cut.pieces_left(), "piece"),
        IsOrAre(cut.pieces_left()), cut.pieces_planned(), IsOrAre(cut.pieces_planned())));
  }
  if (const auto count = cut.pieces_joined(); count > 0) {
    verdict.add_reasons(fmt::format("{} that {} to be apart {} together",
                                    Counted(count, "piece"), IsOrAre(count),
                                    VerbFor(count, "hangs", "hang")));
  }
  if (const auto count = cut.pieces_split(); count > 0) {
    verdict.add_reasons(fmt::format("{} that {} to be whole {} several",
                                    Counted(count, "piece"), IsOrAre(count),
                                    IsOrAre(count)));
  }
  none(cut.beside_mm2(), "{:.3g} mm2 are cleared beside the plan");
  none(cut.uncut_mm2(), "{:.3g} mm2 of the plan are not cleared");
  none(cut.too_deep_mm2(), "{:.3g} mm2 are cut deeper than planned");
  none(cut.through_mm2(),
       "{:.3g} mm2 of the sheet are cut through where they are to hold");
  none(cut.stray_mm(), "the tool was at work for {:.3g} mm beside all marks");
  none(cut.idle_in_sheet_mm(),
       "the tool went {:.3g} mm through the sheet while the spindle was at rest");
}

std::string CutLines(const CutReport& cut) {
  std::string text = fmt::format(
      "tool        {:g} mm, {:g} mm planned; sheet of {:g} mm, cells of {:.0f} um\n",
      cut.tool_diameter_mm(), cut.planned_diameter_mm(), cut.sheet_thickness_mm(),
      cut.cell_um());
  text += fmt::format("pieces      {} left, {} planned, {} joined, {} split\n",
                      cut.pieces_left(), cut.pieces_planned(), cut.pieces_joined(),
                      cut.pieces_split());
  return text + fmt::format(
                    "cleared     {:.2f} mm2, {:.3g} beside the plan, {:.3g} of it not, "
                    "{:.3g} too deep, {:.3g} through; {:.3f} mm deep\n",
                    cut.cleared_mm2(), cut.beside_mm2(), cut.uncut_mm2(),
                    cut.too_deep_mm2(), cut.through_mm2(), cut.deepest_mm());
}

}  // namespace intaglio::client
