// `intaglio drive identify`: the drive of an axis from a record of its motion.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/drive/drive_kinds.h"
#include "engrave/drive/identification.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "engrave/render/chart.h"
#include "engrave/render/png_file.h"
#include "proto/drive_report.pb.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/drive/recorded_axis.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {
namespace {

struct DriveIdentifyOptions {
  std::string record, kind = "second_order", axis = "x", picture;
  bool json = false;
};

// More of a recorded job do not make the figures better, and the search slower.
constexpr std::uint64_t kMaxTicks = 1000;

Result<double> NumberIn(const io::CsvTable& table, const io::CsvRow& row,
                        std::string_view column, const std::string& file) {
  const std::string* text = table.Find(row, column);
  if (text == nullptr) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: has no column {}; give time_s, command and position",
                            file, column));
  }
  const auto number = io::ParseFinite(*text);
  if (!number) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("{}:{}: {} {:?} is no number", file, row.line_number, column, *text),
        *text);
  }
  return *number;
}

bool IsRecording(const std::string& file) {
  return std::filesystem::path(file).extension() == ".mcap";
}

/// The command goes straight from sample to sample.
Result<std::vector<drive::DriveStep>> ReadTable(const std::string& file) {
  const auto table = INTAGLIO_TRY(io::ReadCsv(file));
  std::vector<drive::DriveSample> record;
  for (const io::CsvRow& row : table.rows) {
    drive::DriveSample sample;
    sample.time_s = INTAGLIO_TRY(NumberIn(table, row, "time_s", file));
    sample.command_u = INTAGLIO_TRY(NumberIn(table, row, "command", file));
    sample.position_u = INTAGLIO_TRY(NumberIn(table, row, "position", file));
    record.push_back(sample);
  }
  auto steps = INTAGLIO_TRY(drive::StepsOf(record));
  return steps;
}

/// Axes of a machine with arm and table are the first three, too.
std::size_t AxisIndex(const std::string& name) {
  if (name == "x" || name == "arm") return 0;
  return name == "z" ? 2 : 1;
}

Result<std::vector<drive::DriveStep>> ReadRecord(const DriveIdentifyOptions& options) {
  if (!IsRecording(options.record)) return ReadTable(options.record);
  const auto reader = INTAGLIO_TRY(recording::McapReader::Open(options.record));
  auto axis = INTAGLIO_TRY(ReadAxis(reader, AxisIndex(options.axis), kMaxTicks));
  return std::move(axis.steps);
}

/// Command, measured positions and the answer of the identified drive, over ms.
std::vector<render::Curve> CurvesOf(const drive::Drive& drive,
                                    const std::vector<drive::DriveStep>& steps) {
  render::Curve command{"command", {}}, position{"position", {}};
  render::Curve answer{"identified", {}};
  double at_s = 0;
  const double from_u = steps.front().command.position_u;
  drive::AxisState state = drive.SettledState({from_u});
  command.points.emplace_back(0, from_u);
  answer.points.emplace_back(0, from_u);
  for (const drive::DriveStep& step : steps) {
    state = drive.Follow(state, step.command, step.duration_s);
    at_s += step.duration_s;
    command.points.emplace_back(1e3 * at_s, step.command.At(step.duration_s));
    answer.points.emplace_back(1e3 * at_s, state.position_u);
    if (step.position_u) position.points.emplace_back(1e3 * at_s, *step.position_u);
  }
  return {command, position, answer};
}

std::string ProfileLine(const std::string& kind, const DriveIdentification& found) {
  if (kind == "first_order") {
    return fmt::format("stage_lag_s: {:.6g}", found.parameters(0).value());
  }
  std::string fields;
  for (const IdentifiedFigure& p : found.parameters())
    fields += fmt::format(" {}: {:.6g}", p.name(), p.value());
  return fmt::format("{} {{{} }}", kind, fields);
}

void PrintIdentification(const DriveIdentification& found) {
  for (const IdentifiedFigure& p : found.parameters()) {
    std::cout << fmt::format("{:<24} {:.6g} +- {:.2g}, 95 %\n", p.name(), p.value(),
                             p.interval95());
  }
  std::cout << fmt::format("residual                 {:.4g} rms of {}\n",
                           found.rms_residual(),
                           client::GroupedCount(found.sample_count(), "sample"));
  std::cout << fmt::format("profile                  {}\n", found.profile_line());
}

Result<DriveIdentification> IdentifyFrom(const DriveIdentifyOptions& options) {
  const auto steps = INTAGLIO_TRY(ReadRecord(options));
  const auto found = INTAGLIO_TRY(drive::Identify(options.kind, steps));
  DriveIdentification identified;
  identified.set_drive(options.kind);
  std::vector<double> values;
  for (const drive::IdentifiedParameter& p : found.parameters) {
    IdentifiedFigure& figure = *identified.add_parameters();
    figure.set_name(std::string(p.name));
    figure.set_value(p.value);
    figure.set_interval95(p.interval95);
    values.push_back(p.value);
  }
  identified.set_rms_residual(found.rms_residual_u);
  const auto measured = std::ranges::count_if(
      steps, [](const drive::DriveStep& step) { return step.position_u.has_value(); });
  // A table's first sample is where the axis rests.
  identified.set_sample_count(
      static_cast<std::uint64_t>(measured + (IsRecording(options.record) ? 0 : 1)));
  identified.set_profile_line(ProfileLine(options.kind, identified));
  if (options.picture.empty()) return identified;
  const auto drive = INTAGLIO_TRY(drive::MakeDrive(options.kind, values));
  INTAGLIO_TRY(render::WritePng(
      options.picture,
      render::DrawChart(CurvesOf(*drive, steps),
                        {"Identified drive: " + options.kind, "time, ms", "position"})));
  return identified;
}

int IdentifyDrive(const DriveIdentifyOptions& options) {
  const auto found = IdentifyFrom(options);
  if (!found) return Complain(found.error(), client::kExitWrongInput);
  if (options.json) return PrintJson(*found);
  PrintIdentification(*found);
  return client::kExitGood;
}

}  // namespace

void AddDriveIdentifyCommand(command_line::Command drive) {
  auto o = std::make_shared<DriveIdentifyOptions>();
  std::vector<std::string> kinds;
  for (const drive::DriveKind& kind : drive::DriveKinds()) kinds.emplace_back(kind.name);
  command_line::Command identify = drive.AddCommand(
      "identify", "the parameters of a drive from its command and its position");
  identify
      .AddOption(
          "record", o->record,
          "CSV with the columns time_s, command, position; or .mcap, the recording "
          "of a job")
      .Require();
  identify.AddOption("--drive", o->kind, "kind of the profile's drive")
      .OneOf(kinds)
      .ShowDefault();
  identify.AddOption("--axis", o->axis, "axis of a recorded job")
      .OneOf({"x", "y", "z", "arm", "table"})
      .ShowDefault();
  identify.AddFlag("--json", o->json, "the figures for programs");
  identify.AddOption("--picture", o->picture, "PNG: the record and the identified drive");
  identify.SetFooter(
      "Example: intaglio drive identify record.csv --drive second_order\n"
      "The axis rests at the first sample. Of a job's recording the first 1000 ticks of "
      "its "
      "longest motion are used. The last line is for the machine profile.\n"
      "Exit code: 0 good, 2 wrong input.");
  identify.SetAction([o] { return IdentifyDrive(*o); });
}

}  // namespace intaglio::cli
