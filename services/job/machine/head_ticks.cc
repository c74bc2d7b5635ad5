#include "services/job/machine/head_ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

// Arcs as chords: far below a step of the outputs.
constexpr double kChordToleranceMm = 1e-4;
constexpr double kDefaultAheadMs = 40;
// From one status of a head's controller to the next, with what it has seen meanwhile.
constexpr double kHeadStatusSeconds = 0.02;
// Of the driver that sends ticks; controllers of other protocols make strokes by
// themselves.
constexpr char kTickProtocol[] = "scan-head";
// Of the tolerance: how far whole ticks may shift a dot of a row.
constexpr double kDotShiftRatio = 0.5;

std::vector<galvo::LitSpan> LitSpansOf(const mark::Mark& row) {
  const Vec2& begin_mm = row.places.front().at_mm;
  std::vector<galvo::LitSpan> spans;
  for (const std::vector<Vec2>& way : mark::LitWaysOf(row, kChordToleranceMm))
    spans.push_back({(way.front() - begin_mm).norm(), (way.back() - begin_mm).norm()});
  return spans;
}

}  // namespace

bool FollowsWeb(const ScanHead& head) {
  return head.encoder_count_um() > 0 && (!head.has_follow_web() || head.follow_web());
}

double AheadSeconds(const ScanHead& head) {
  return 1e-3 * (head.has_ahead_ms() ? head.ahead_ms() : kDefaultAheadMs);
}

double EyeAheadSeconds(const ScanHead& head) {
  return std::max(AheadSeconds(head), kHeadStatusSeconds + AheadSeconds(head) / 2);
}

galvo::MarkTickOptions TickOptionsOf(const ScanHead& head, const mark::Pen& pen,
                                     double rate_hz) {
  galvo::MarkTickOptions options;
  options.rate_hz = rate_hz;
  options.mark_mm_s = pen.speed_mm_s;
  options.jump_mm_s = head.jump_mm_s();
  options.run_in_s = head.has_run_in_s() ? head.run_in_s() : kDefaultRunInSeconds;
  options.lag_s = head.servo_lag_s();
  options.lead_servo = head.has_lead_servo() ? head.lead_servo() : head.servo_lag_s() > 0;
  if (options.lead_servo) return options;
  options.laser_on_delay_s = head.laser_on_delay_s();
  options.laser_off_delay_s = head.laser_off_delay_s();
  options.jump_delay_s = head.jump_delay_s();
  options.mark_delay_s = head.mark_delay_s();
  options.polygon_delay_s = head.polygon_delay_s();
  return options;
}

double MarkToleranceUm(const MachineSpec& machine) {
  if (machine.scan_head().has_tolerance_um()) return machine.scan_head().tolerance_um();
  return !machine.has_scan_head() && machine.position_tolerance_um() > 0
             ? machine.position_tolerance_um()
             : DefaultOf<ScanHead>(ScanHead::kToleranceUmFieldNumber);
}

std::string WhyNoDotRows(const MachineSpec& machine, double dot_mm, double speed_mm_s) {
  const ScanHead& head = machine.scan_head();
  if (machine.mark_line().protocol() != kTickProtocol) {
    return fmt::format(
        "a controller of mark_line.protocol \"{}\" does not switch the "
        "laser while the mirrors sweep; name another machine",
        machine.mark_line().protocol());
  }
  const galvo::MarkTickOptions ticks =
      TickOptionsOf(head, mark::Pen(), galvo::MarkTickOptions().rate_hz);
  if (!ticks.lead_servo && ticks.run_in_s == 0)
    return "scan_head.run_in_s is 0, so that rows would begin from rest; give a run-in";
  const double step_mm = speed_mm_s / ticks.rate_hz;
  const double max_step_mm =
      std::min(dot_mm, 2 * kDotShiftRatio * 1e-3 * MarkToleranceUm(machine));
  if (step_mm <= max_step_mm * (1 + 1e-9)) return {};
  return fmt::format(
      "the beam passes {:.3g} mm in a tick at {:.6g} mm/s, more than {}; "
      "mark at {:.6g} mm/s or less",
      step_mm, speed_mm_s,
      max_step_mm == dot_mm
          ? fmt::format("a dot of {:.3g} mm", dot_mm)
          : fmt::format("the {:.3g} mm that scan_head.tolerance_um permits", max_step_mm),
      max_step_mm * ticks.rate_hz);
}

std::vector<galvo::MarkStroke> StrokesOf(const mark::Mark& mark, const mark::Pen& pen) {
  galvo::MarkStroke stroke{mark::PlacesOf(mark, kChordToleranceMm), mark.closed};
  if (mark::IsRow(mark)) {
    stroke.lit = LitSpansOf(mark);
    stroke.points_mm = {stroke.points_mm.front(), stroke.points_mm.back()};
  }
  for (Vec2& place : stroke.points_mm) place.x() -= mark.web_mm;
  std::vector<galvo::MarkStroke> passes;
  passes.reserve(pen.pass_count);
  for (std::uint32_t i = 1; i < pen.pass_count; ++i) passes.push_back(stroke);
  passes.push_back(std::move(stroke));
  return passes;
}

}  // namespace intaglio
