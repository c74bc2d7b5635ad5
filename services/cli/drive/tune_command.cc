// `intaglio drive tune` and `intaglio drive compare`: gains with their reasons, and what
// those of the panel do beside them.

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "proto/drive_report.pb.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/drive/regime_answers.h"
#include "services/cli/flags/drive_profile_flag.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio::cli {
namespace {

constexpr auto kTunedRule = drive::CylinderRule::kSolid;

struct DriveTuneOptions {
  std::string profile, regime = "rapid";
  double damping_ratio = 0.7;
  bool json = false;
};

drive::Regime RegimeOf(const std::string& name) {
  if (name == "circle") return drive::Regime::kCircle;
  return name == "corner" ? drive::Regime::kCorner : drive::Regime::kRapid;
}

std::vector<drive::Tuning> TuningsOf(const DriveProfile& profile,
                                     const DriveTuneOptions& options) {
  std::vector<drive::TunedAxis> axes;
  for (const DriveAxis& axis : profile.axes())
    axes.push_back(TunedAxisOf(profile, axis, kTunedRule));
  return drive::Tune(
      axes,
      {RegimeOf(options.regime), profile.max_speed_m_s(), profile.controller().period_s(),
       profile.controller().holds_references(), options.damping_ratio});
}

/// A gain as the axis' panel counts it: V per m over the volts of a unit.
double OnPanel(const DriveProfile& profile, const DriveAxis& axis, double volt_per_m) {
  const double units_per_m = axis.panel().unit() == DRIVE_PANEL_UNIT_VOLT_PER_MM
                                 ? 1000
                                 : profile.controller().counts_per_m();
  return volt_per_m / (VoltPerStep(profile, axis) * units_per_m);
}

DriveLoop TunedLoopOf(const DriveProfile& profile, const DriveAxis& axis,
                      const drive::Tuning& t) {
  DriveLoop loop;
  loop.set_axis(axis.name());
  loop.set_gains("tuned");
  loop.set_position_gain_per_s(t.servo.position_gain_per_s);
  loop.set_damping_ratio(drive::DampingRatio(t.servo));
  loop.set_lag_ms(1e3 * t.following_lag_s);
  loop.set_static_error_um(1e6 * t.static_error_m);
  loop.set_longest_period_ms(1e3 * t.largest_stable_period_s);
  loop.set_stable(t.largest_stable_period_s > profile.controller().period_s());
  loop.set_panel_proportional(OnPanel(profile, axis, t.loop.volt_per_m));
  loop.set_panel_derivative(OnPanel(profile, axis, t.loop.volt_s_per_m));
  for (const drive::Advice& a : t.advice) {
    GainAdvice& advice = *loop.add_advice();
    advice.set_gain(std::string(a.gain));
    advice.set_value(a.value);
    advice.set_limit(a.limit);
    advice.set_reason(a.reason);
  }
  return loop;
}

int PrintLoops(const DriveProfile& profile, DriveLoops loops) {
  loops.set_period_ms(1e3 * profile.controller().period_s());
  return PrintJson(loops);
}

int TuneJson(const DriveProfile& profile, const std::vector<drive::Tuning>& tunings) {
  DriveLoops loops;
  for (std::size_t i = 0; i < tunings.size(); ++i)
    *loops.add_loops() =
        TunedLoopOf(profile, profile.axes(static_cast<int>(i)), tunings[i]);
  return PrintLoops(profile, std::move(loops));
}

int Tune(const DriveTuneOptions& options) {
  const auto profile = NamedDriveProfile(options.profile);
  if (!profile) return Complain(profile.error(), client::kExitWrongInput);
  const auto tunings = TuningsOf(*profile, options);
  if (options.json) return TuneJson(*profile, tunings);
  for (std::size_t i = 0; i < tunings.size(); ++i) {
    const drive::Tuning& t = tunings[i];
    const DriveAxis& axis = profile->axes(static_cast<int>(i));
    std::cout << fmt::format(
        "axis          {}\npanel         proportional {:.6g}, derivative {:.6g}\n",
        t.axis, OnPanel(*profile, axis, t.loop.volt_per_m),
        OnPanel(*profile, axis, t.loop.volt_s_per_m));
    for (const drive::Advice& a : t.advice) {
      std::cout << fmt::format("{:<13} {:.6g}, not above {:.6g}: {}\n", a.gain, a.value,
                               a.limit, a.reason);
    }
    std::cout << fmt::format(
        "result        damping {:.3g}, lag {:.4g} ms, static error {:.4g} um, stable up "
        "to {:.4g} ms\n",
        drive::DampingRatio(t.servo), 1e3 * t.following_lag_s, 1e6 * t.static_error_m,
        1e3 * t.largest_stable_period_s);
  }
  return client::kExitGood;
}

struct CompareRow {
  std::string name, gains;
  drive::ServoLoop servo;
  double static_error_m = 0, stable_period_s = 0;
};

std::string RowText(const DriveProfile& profile, const CompareRow& row) {
  const double period_s = profile.controller().period_s();
  return fmt::format("{:<8} {:<8} {:>10.5g} {:>8.3g} {:>9.4g} {:>10.4g} {:>11.4g} {}\n",
                     row.name, row.gains, row.servo.position_gain_per_s,
                     drive::DampingRatio(row.servo), 1e3 * drive::LagSeconds(row.servo),
                     1e6 * row.static_error_m, 1e3 * row.stable_period_s,
                     row.stable_period_s > period_s ? "stable" : "NOT STABLE");
}

CompareRow PanelRow(const DriveProfile& profile, const DriveAxis& axis) {
  const drive::SampledAxis sampled = SampledAxisOf(profile, axis, kTunedRule);
  CompareRow panel{
      axis.name(), "panel",
      drive::CloseAxis(VelocityLoopOf(axis, kTunedRule), PositionLoopOf(profile, axis),
                       axis.screw().lead_m())};
  panel.static_error_m = drive::StaticError(panel.servo, sampled.friction_m_s2);
  panel.stable_period_s = drive::LargestStablePeriod(sampled);
  return panel;
}

DriveLoop LoopOf(const DriveProfile& profile, const CompareRow& row) {
  DriveLoop loop;
  loop.set_axis(row.name);
  loop.set_gains(row.gains);
  loop.set_position_gain_per_s(row.servo.position_gain_per_s);
  loop.set_damping_ratio(drive::DampingRatio(row.servo));
  loop.set_lag_ms(1e3 * drive::LagSeconds(row.servo));
  loop.set_static_error_um(1e6 * row.static_error_m);
  loop.set_longest_period_ms(1e3 * row.stable_period_s);
  loop.set_stable(row.stable_period_s > profile.controller().period_s());
  return loop;
}

/// The answers of the panel's gains and of the tuned ones, regime by regime.
std::vector<RegimeAnswer> AnswersOfBoth(const DriveProfile& profile,
                                        const std::vector<drive::Tuning>& tunings) {
  NamedLoops panel{"panel", {}}, tuned{"tuned", {}};
  for (int axis = 0; axis < profile.axes_size(); ++axis) {
    panel.loops.push_back(PositionLoopOf(profile, profile.axes(axis)));
    tuned.loops.push_back(tunings[static_cast<std::size_t>(axis)].loop);
  }
  const auto of_panel = AnswersOf(profile, panel), of_tuned = AnswersOf(profile, tuned);
  std::vector<RegimeAnswer> both;
  for (std::size_t i = 0; i < of_panel.size(); ++i)
    both.insert(both.end(), {of_panel[i], of_tuned[i]});
  return both;
}

int Compare(const DriveTuneOptions& options) {
  const auto profile = NamedDriveProfile(options.profile);
  if (!profile) return Complain(profile.error(), client::kExitWrongInput);
  std::string text =
      fmt::format("{:<8} {:<8} {:>10} {:>8} {:>9} {:>10} {:>11} {}\n", "axis", "gains",
                  "K, 1/s", "damping", "lag, ms", "static, um", "period, ms",
                  fmt::format("at {:g} ms", 1e3 * profile->controller().period_s()));
  DriveLoops loops;
  bool all_stable = true;
  const auto tunings = TuningsOf(*profile, options);
  for (std::size_t i = 0; i < tunings.size(); ++i) {
    const DriveAxis& axis = profile->axes(static_cast<int>(i));
    const CompareRow panel = PanelRow(*profile, axis);
    all_stable = all_stable && panel.stable_period_s > profile->controller().period_s();
    text += RowText(*profile, panel) +
            RowText(*profile,
                    {axis.name(), "tuned", tunings[i].servo, tunings[i].static_error_m,
                     tunings[i].largest_stable_period_s});
    *loops.add_loops() = LoopOf(*profile, panel);
    *loops.add_loops() = TunedLoopOf(*profile, axis, tunings[i]);
  }
  for (const RegimeAnswer& answer : AnswersOfBoth(*profile, tunings)) {
    text += AnswerText(answer);
    *loops.add_answers() = answer;
  }
  const int code = all_stable ? client::kExitGood : client::kExitNotGood;
  if (options.json) {
    const int failed = PrintLoops(*profile, std::move(loops));
    return failed != client::kExitGood ? failed : code;
  }
  std::cout << text;
  return code;
}

void AddTuneOptions(command_line::Command command, DriveTuneOptions& options) {
  command
      .AddOption("profile", options.profile,
                 "drive profile: a supplied one, or a file .textproto")
      .Require();
  command
      .AddOption("--regime", options.regime,
                 "what the axes do most: rapid (default), circle, corner")
      .OneOf({"rapid", "circle", "corner"});
  command.AddOption("--damping", options.damping_ratio, "of the position loop")
      .Within(0.3, 2.0)
      .ShowDefault();
  command.AddFlag("--json", options.json, "the figures for programs");
}

}  // namespace

void AddDriveTuneCommands(command_line::Command drive) {
  auto of_tune = std::make_shared<DriveTuneOptions>();
  command_line::Command tune =
      drive.AddCommand("tune", "gains of the axes, each with its reason and its limit");
  AddTuneOptions(tune, *of_tune);
  tune.SetFooter(
      "Example: intaglio drive tune deploy/drives/tirnovean-2016.textproto --regime "
      "circle\n"
      "Exit code: 0 good, 2 wrong input.");
  tune.SetAction([of_tune] { return Tune(*of_tune); });
  auto of_compare = std::make_shared<DriveTuneOptions>();
  command_line::Command compare = drive.AddCommand(
      "compare", "the gains of the panel beside the tuned ones, in each regime");
  AddTuneOptions(compare, *of_compare);
  compare.SetFooter(
      "Example: intaglio drive compare deploy/drives/tirnovean-2016.textproto\n"
      "Exit code: 0 good, 2 wrong input, 3 a loop of the panel is not stable.");
  compare.SetAction([of_compare] { return Compare(*of_compare); });
}

}  // namespace intaglio::cli
