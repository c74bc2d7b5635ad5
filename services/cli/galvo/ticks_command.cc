// `intaglio galvo ticks`: the outputs of a scan head for a drawing on a piece at rest.

#include <fmt/format.h>

#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/files/xy2_100.h"
#include "engrave/io/atomic_file.h"
#include "services/cli/galvo/correction_source.h"
#include "services/cli/galvo/drawing_strokes.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

struct TicksOptions {
  DrawingOptions drawing;
  std::string table, csv, xy2;
  std::optional<double> field_mm, table_bits;
  double run_in_ms = 0, lag_ms = 0;
  double laser_on_us = 0, laser_off_us = 0, jump_us = 0, mark_us = 0, polygon_us = 0;
  bool lead = false;
};

galvo::MarkTickOptions TickOptionsOf(const TicksOptions& o) {
  galvo::MarkTickOptions ticks;
  ticks.mark_mm_s = o.drawing.mark_mm_s;
  ticks.jump_mm_s = o.drawing.jump_mm_s;
  ticks.run_in_s = o.run_in_ms / 1e3;
  ticks.lag_s = o.lag_ms / 1e3;
  ticks.lead_servo = o.lead;
  ticks.laser_on_delay_s = o.laser_on_us / 1e6;
  ticks.laser_off_delay_s = o.laser_off_us / 1e6;
  ticks.jump_delay_s = o.jump_us / 1e6;
  ticks.mark_delay_s = o.mark_us / 1e6;
  ticks.polygon_delay_s = o.polygon_us / 1e6;
  return ticks;
}

/// Full scale of the outputs, mm: of a .ct5 file 2^20 bit by its calibration.
Result<double> FullScaleMm(const TicksOptions& options, const CorrectionSource* table) {
  if (options.field_mm) return *options.field_mm;
  if (table != nullptr && table->ct5)
    return (1 << 20) / static_cast<double>(table->ct5->header[galvo::kCt5Calibration]);
  return Fail(ErrorCode::kMissing,
              "--field: full scale of the outputs, mm, is needed without a --table .ct5");
}

Status WriteOutputs(const std::string& file,
                    const std::vector<galvo::HeadOutput>& outputs) {
  std::string text = "tick,x,y,laser\n";
  for (std::size_t k = 0; k < outputs.size(); ++k)
    fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", k, outputs[k].x,
                   outputs[k].y, outputs[k].laser ? 1 : 0);
  return io::WriteFileAtomically(file, std::string_view(text));
}

Status MakeTicks(const TicksOptions& options) {
  const auto strokes = INTAGLIO_TRY(ReadMarkStrokes(options.drawing));
  std::optional<CorrectionSource> table;
  if (!options.table.empty())
    table = INTAGLIO_TRY(ReadCorrection(options.table, options.table_bits));
  const double field_mm = INTAGLIO_TRY(FullScaleMm(options, table ? &*table : nullptr));
  const auto ticks =
      INTAGLIO_TRY(galvo::MakeMarkTicks(strokes, Vec2::Zero(), TickOptionsOf(options)));
  galvo::OutputMaker maker(field_mm, table ? &table->commands : nullptr);
  std::vector<galvo::HeadOutput> outputs;
  std::size_t lit = 0;
  for (const galvo::MarkTick& tick : ticks) {
    outputs.push_back(maker.Make(tick, Vec2::Zero()));
    lit += tick.laser;
  }
  if (maker.lit_outside_count() > 0) {
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("{}: {} of {} {} outside the field of {:.6g} mm; "
                            "make the drawing smaller",
                            options.drawing.file, maker.lit_outside_count(),
                            Counted(lit, "lit tick"), IsOrAre(maker.lit_outside_count()),
                            field_mm));
  }
  std::cout << fmt::format(
      "strokes       {}\nticks         {} of 10 us, {} with the laser\n"
      "resolution    {:.3g} um\n",
      strokes.size(), ticks.size(), lit, 1e3 * field_mm / 65536);
  if (!options.csv.empty()) INTAGLIO_TRY(WriteOutputs(options.csv, outputs));
  if (options.xy2.empty()) return {};
  const std::string capture = INTAGLIO_TRY(galvo::WriteXy2Capture(outputs));
  return io::WriteFileAtomically(options.xy2, std::string_view(capture));
}

void AddDelays(command_line::Command ticks, TicksOptions& o) {
  ticks.AddOption("--laser-on-delay", o.laser_on_us, "us after the command")
      .Within(0.0, 10000.0)
      .ShowDefault();
  ticks.AddOption("--laser-off-delay", o.laser_off_us, "us after the command")
      .Within(0.0, 10000.0)
      .ShowDefault();
  ticks.AddOption("--jump-delay", o.jump_us, "us of rest after a jump")
      .Within(0.0, 10000.0)
      .ShowDefault();
  ticks.AddOption("--mark-delay", o.mark_us, "us of rest after a mark")
      .Within(0.0, 10000.0)
      .ShowDefault();
  ticks.AddOption("--polygon-delay", o.polygon_us, "us times 1 - cos of a corner")
      .Within(0.0, 10000.0)
      .ShowDefault();
}

}  // namespace

void AddGalvoTicksCommand(command_line::Command galvo) {
  auto o = std::make_shared<TicksOptions>();
  command_line::Command ticks =
      galvo.AddCommand("ticks", "the outputs of a head for a drawing, 100 kHz");
  AddDrawingOptions(ticks, o->drawing);
  ticks
      .AddOption("--field", o->field_mm,
                 "full scale of the outputs, mm; default that of a --table .ct5")
      .Within(1.0, 2000.0);
  ticks.AddOption("--table", o->table, "correction: .ct5, .ctb, .cor");
  ticks.AddOption("--table-bits", o->table_bits, "bit/mm of a .ctb file")
      .Within(0.1, 65536.0);
  ticks.AddOption("--run-in", o->run_in_ms, "ms at speed before and behind a stroke")
      .Within(0.0, 100.0)
      .ShowDefault();
  const auto lag = ticks.AddOption("--lag", o->lag_ms, "ms, tracking delay of the servo")
                       .Within(0.0, 10.0);
  ticks.AddFlag("--lead", o->lead, "commands ahead of the servo by its lag").Need(lag);
  AddDelays(ticks, *o);
  ticks.AddOption("--csv", o->csv, "outputs: tick,x,y,laser");
  ticks.AddOption("--capture", o->xy2, "XY2-100 frames as a value change dump, .vcd");
  ticks.SetFooter(
      "Example: intaglio galvo ticks part.svg --table new.ct5 --capture part.vcd\n"
      "Exit code: 0 good, 2 wrong input.");
  ticks.SetAction([o]() -> int {
    if (const auto done = MakeTicks(*o); !done)
      return Complain(done.error(), client::kExitWrongInput);
    return client::kExitGood;
  });
}

}  // namespace intaglio::cli
