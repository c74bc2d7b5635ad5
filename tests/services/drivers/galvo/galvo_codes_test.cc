// Data Matrix codes of a table on a web that moves under the virtual head: what its
// record says was burnt is drawn at its places of the material and read by another
// library.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "services/job/files/job_file.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/web_run.h"
#include "tests/engrave/mark/burnt_picture.h"
#include "tests/engrave/matrix_code/code_reader.h"
#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

constexpr double kBurntLineMm = 0.2, kPixelMm = 0.06, kQuietMm = 2;
// Codes are 7 mm long and 15 mm apart.
constexpr double kGapBetweenCodesMm = 4;

/// 1000 by INTAGLIO_CODE_COUNT=1000.
std::size_t CodesAsked() {
  const char* const asked = std::getenv("INTAGLIO_CODE_COUNT");
  return asked == nullptr ? 12 : std::stoul(asked);
}

std::vector<std::string> SerialNumbers() {
  std::vector<std::string> serials;
  for (std::size_t i = 0; i < CodesAsked(); ++i)
    serials.push_back(fmt::format("SN-{:05}", 7919 * i % 100'000));
  return serials;
}

MachineSpec CodeHead() {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_field_mm(60);
  machine.mutable_scan_head()->set_encoder_count_um(23);
  return machine;
}

JobSpec CodeJob() {
  return ParseJob(R"(marks {
      items { code { text: "{serial}" module_mm: 0.5 }
              hatch { distance_mm: 0.17 inset_mm: 0.1 } }
      pen { speed_mm_s: 2000 }
      table: "serials.csv" repeats { pitch_mm: 15 } web {} })",
                  JobFileFormat::kText, "job")
      .value();
}

/// The marks of the job in their order.
mark::MarkSet OrderedCodes(const JobSpec& job, const MachineSpec& machine) {
  std::string table = "serial\n";
  for (const std::string& serial : SerialNumbers()) table += serial + "\n";
  const auto* first = reinterpret_cast<const std::byte*>(table.data());
  Warnings warnings;
  auto made = MakeJobMarks(job, machine, {FileBytes(first, first + table.size())},
                           ReadLimits(), warnings, nullptr);
  return OrderJobMarks(job, machine, std::move(made.value())).value();
}

/// What lies together on the material, along the web, which moves to larger x.
std::vector<std::vector<formats::BurntTick>> PiecesOf(
    std::vector<formats::BurntTick> ticks) {
  std::ranges::sort(ticks, [](const auto& a, const auto& b) {
    return a.place_mm.x() > b.place_mm.x();
  });
  std::vector<std::vector<formats::BurntTick>> pieces;
  for (const formats::BurntTick& tick : ticks) {
    if (pieces.empty() ||
        pieces.back().back().place_mm.x() - tick.place_mm.x() > kGapBetweenCodesMm)
      pieces.emplace_back();
    pieces.back().push_back(tick);
  }
  return pieces;
}

mark::BurntPicture PictureOf(const std::vector<formats::BurntTick>& ticks) {
  Box3 box;
  std::vector<mark::Mark> strokes;
  for (const formats::BurntTick& tick : ticks) {
    const Vec2 from_mm = tick.place_mm - tick.way_mm;
    strokes.push_back(LineMark(from_mm, tick.place_mm));
    for (const Vec2& place : {from_mm, tick.place_mm})
      box.Extend(Vec3(place.x(), place.y(), 0));
  }
  const Vec2 rim(kQuietMm, kQuietMm);
  return mark::Burn(strokes, kBurntLineMm, box.min_mm.head<2>() - rim,
                    box.max_mm.head<2>() + rim, kPixelMm);
}

TEST(GalvoCodes, EachDataMatrixOfATableIsReadFromWhatTheHeadBurnt) {
  if (!matrix_code::CanReadDataMatrix()) GTEST_SKIP() << "libdmtx is not installed";
  const MachineSpec machine = CodeHead();
  const JobSpec job = CodeJob();
  const mark::MarkSet set = OrderedCodes(job, machine);
  auto truth = HeadTruthOf(machine);
  truth.physics.web_mm_s = 0.98 * WebRunOf(job, machine, set).value().max_mm_s;
  HeadBench bench(machine, truth);
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  bench.Run(1, set);
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_EQ(bench.state().fault, "");
  const auto pieces = PiecesOf(bench.Burnt());
  const std::vector<std::string> serials = SerialNumbers();
  ASSERT_EQ(pieces.size(), serials.size());
  std::size_t right = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto read = matrix_code::ReadDataMatrix(PictureOf(pieces[i]));
    EXPECT_EQ(read, serials[i]) << i;
    right += read == serials[i];
  }
  RecordProperty("web",
                 fmt::format("{} of {} codes right at {:.1f} mm/s, {} marks", right,
                             serials.size(), truth.physics.web_mm_s, set.marks.size()));
}

}  // namespace
}  // namespace intaglio::drivers
