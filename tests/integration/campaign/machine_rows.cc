#include "tests/integration/campaign/machine_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "engrave/formats/mark_record.h"
#include "engrave/formats/point_file.h"
#include "engrave/mark/mark_file.h"
#include "tests/integration/course/flashes.h"
#include "tests/integration/course/tool_way.h"

namespace intaglio::campaign {
namespace {

namespace fs = std::filesystem;
using Controller = MachineRow::Controller;

// Squares into a sheet, and circles on a piece.
constexpr int kSquares = 12, kCircles = 40;
constexpr double kSquare_mm = 3, kCell_mm = 5, kRadius_mm = 0.5;

std::string Squares() {
  std::string text = R"(<svg xmlns="http://www.w3.org/2000/svg" width="30mm" )"
                     R"(height="10mm" viewBox="0 0 30 10">)";
  for (int i = 0; i < kSquares; ++i) {
    text += fmt::format(R"(<rect x="{}" y="{}" width="{}" height="{}"/>)",
                        1 + kCell_mm * (i % 6), 1 + kCell_mm * (i / 6), kSquare_mm,
                        kSquare_mm);
  }
  return text + "</svg>";
}

std::string Circles() {
  std::string text = R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" )"
                     R"(height="40mm" viewBox="0 0 40 40">)";
  for (int i = 0; i < kCircles; ++i) {
    text += fmt::format(R"(<circle cx="{}" cy="{}" r="{}"/>)", 1 + 2 * (i % 20),
                        1 + 2 * (i / 20), kRadius_mm);
  }
  return text + "</svg>";
}

Vec3 Flat(const Vec2& place_mm) { return {place_mm.x(), place_mm.y(), 0}; }

Result<std::vector<Item>> MarksOf(const Records& records, const std::vector<WorkPiece>&) {
  const auto set = mark::ReadMarkFile(records.job / "marks.bin");
  if (!set) return tl::unexpected(set.error());
  std::vector<Item> items;
  for (const mark::Mark& mark : set->marks) {
    Item& item = items.emplace_back();
    for (const Vec2& place_mm : mark::PlacesOf(mark, 0.001))
      item.push_back(Flat(place_mm));
    if (mark.closed) item.push_back(item.front());
  }
  return items;
}

Result<std::vector<Item>> PointsOf(const Records& records,
                                   const std::vector<WorkPiece>& work) {
  const auto path = formats::ReadPly(records.job / "path.ply");
  if (!path) return tl::unexpected(path.error());
  PointList flashes_mm;
  for (const WorkPiece& piece : work) flashes_mm.push_back(piece.from_mm);
  const auto fit = testing::FitHeight(path->points_mm, flashes_mm);
  std::vector<Item> items;
  for (const Vec3& point_mm : path->points_mm) items.push_back({fit.AxesAt(point_mm)});
  return items;
}

std::vector<WorkPiece> FlashesOf(const Records& records) {
  std::vector<WorkPiece> work;
  for (const Vec3& at_mm : testing::ReadFlashes(records.machine / "record.txt").began_mm)
    work.push_back({at_mm, at_mm, true});
  return work;
}

template <bool kInWork>
std::vector<WorkPiece> WayOf(const Records& records) {
  std::vector<WorkPiece> work;
  for (const testing::ToolStep& step :
       testing::ReadToolWay(records.machine / "way.txt")) {
    if (step.on && (!kInWork || step.lowest_mm() < 0))
      work.push_back({Flat(step.from_mm.head<2>()), Flat(step.to_mm.head<2>())});
  }
  return work;
}

/// Ticks of one mark that follow each other, as pieces of about a focus.
std::vector<WorkPiece> BurntOf(const Records& records) {
  constexpr double kPiece_mm = 0.02;
  std::vector<WorkPiece> work;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(records.machine))
    if (entry.path().extension() == ".rec") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const auto record = formats::ReadMarkRecord(file);
    if (!record) continue;
    const formats::BurntTick* before = nullptr;
    for (const formats::BurntTick& tick : record->ticks) {
      const Vec3 to_mm = Flat(tick.place_mm);
      const bool goes_on = before != nullptr && tick.tick == before->tick + 1 &&
                           tick.mark == before->mark && tick.run == before->run &&
                           (work.back().to_mm - work.back().from_mm).norm() < kPiece_mm;
      if (goes_on)
        work.back().to_mm = to_mm;
      else
        work.push_back({Flat(tick.place_mm - tick.way_mm), to_mm});
      before = &tick;
    }
  }
  return work;
}

MachineRow PointsRow() {
  MachineRow row;
  row.name = "grbl-points";
  row.profile = "grbl";
  row.controller = Controller::kGrbl;
  row.options = {"--hal"};
  row.fields = {{"  warm_up_s", "  warm_up_s: 0"}};
  row.mounted = {"--block", "50", "50", "30", "--block-glass", "N-BK7"};
  row.job =
      "name: \"knot\" glass: \"N-BK7\" block { size_mm { x: 50 y: 50 z: 30 } }\n"
      "models { file: \"" INTAGLIO_SOURCE_DIR
      "/deploy/jobs/sample.obj\" placement { fit_height_mm: 1.8 } }\n"
      "discretization { min_spacing_mm: 0.3 }\n"
      "laser { photosensor_feedback: false rate_hz: 50 }\n";
  row.services = {"intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
                  "intaglio-synchronizer", "intaglio-motion-bridge"};
  row.line_service = "intaglio-motion-bridge";
  row.numbers_power_ups = false;
  row.near_mm = 0.05;
  row.amount = 140;
  row.items = PointsOf;
  row.work = FlashesOf;
  return row;
}

MachineRow CourseRow() {
  MachineRow row;
  row.controller = Controller::kGrbl;
  row.options = {"--hal"};
  row.mounted = {"--piece", "sheet"};
  row.drawing = Squares();
  row.services = {"intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
                  "intaglio-marker"};
  row.line_service = "intaglio-marker";
  row.numbers_power_ups = false;
  row.near_mm = 0.05;
  row.items = MarksOf;
  return row;
}

MachineRow LaserRow() {
  MachineRow row = CourseRow();
  row.name = "grbl-laser";
  row.profile = "laser-cutter";
  row.job =
      "name: \"squares\" course { files: \"drawing.svg\" make: COURSE_MAKE_CUT "
      "inside: true tool_diameter_mm: 0.2 power_ratio: 0.5 speed_mm_s: 20 }\n";
  row.amount = 4 * kSquares * (kSquare_mm - 0.2);
  row.work = WayOf<false>;
  return row;
}

MachineRow MillRow() {
  MachineRow row = CourseRow();
  row.name = "mill";
  row.profile = "mill";
  row.options = {"--hal", "--spindle"};
  row.fields = {{"  spin_up_s", "  spin_up_s: 1"}};
  row.job =
      "name: \"squares\" course { files: \"drawing.svg\" make: COURSE_MAKE_CUT "
      "inside: true tool_diameter_mm: 1 depth_mm: 0.5 plunge_mm_s: 10 "
      "speed_mm_s: 15 }\n";
  row.amount = 4 * kSquares * (kSquare_mm - 1);
  row.work = WayOf<true>;
  return row;
}

MachineRow HeadRow() {
  MachineRow row;
  row.name = "scan-head";
  row.profile = "galvo";
  row.controller = Controller::kScanHead;
  row.mounted = {"--piece", "plate"};
  row.job =
      "name: \"circles\" marks { items { drawing { file: \"drawing.svg\" } } "
      "pen { speed_mm_s: 20 power_ratio: 0.5 } }\n";
  row.drawing = Circles();
  row.services = {"intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
                  "intaglio-marker"};
  row.line_service = "intaglio-marker";
  row.numbers_power_ups = true;
  // tolerance_um of the profile and the way of two ticks.
  row.near_mm = 0.03;
  row.amount = kCircles * 2 * std::numbers::pi * kRadius_mm;
  row.items = MarksOf;
  row.work = BurntOf;
  return row;
}

}  // namespace

const std::vector<MachineRow>& MachineRows() {
  static const std::vector<MachineRow> rows = {PointsRow(), LaserRow(), MillRow(),
                                               HeadRow()};
  return rows;
}

bool HasFault(const MachineRow& machine, const FaultRow& fault) {
  if (fault.by == FaultRow::By::kKill && fault.act != "intaglio-up")
    return std::ranges::find(machine.services, fault.act) != machine.services.end();
  const bool is_head = machine.controller == Controller::kScanHead;
  // A chain of contacts at one input has no key of its own.
  return is_head ? fault.of_scan_head : std::string(fault.name) != "key";
}

bool NeedsPerson(const MachineRow& machine, const FaultRow& fault) {
  const bool ends_line =
      fault.by == FaultRow::By::kKill &&
      (fault.act == machine.line_service || fault.act == "intaglio-up");
  return fault.needs_person || (ends_line && !machine.numbers_power_ups);
}

bool LosesPlace(const MachineRow& machine, const FaultRow& fault) {
  return fault.loses_place && machine.controller == Controller::kGrbl;
}

}  // namespace intaglio::campaign
