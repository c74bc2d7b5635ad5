// `intaglio drive identify`: the drive of an axis from a record of its motion.

#include <fmt/format.h>

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
#include "services/cli/complain.h"
#include "services/cli/drive/drive_command.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

struct DriveIdentifyOptions {
  std::string record, kind = "second_order", picture;
};

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

Result<std::vector<drive::DriveSample>> ReadRecord(const std::string& file) {
  const auto table = INTAGLIO_TRY(io::ReadCsv(file));
  std::vector<drive::DriveSample> record;
  for (const io::CsvRow& row : table.rows) {
    drive::DriveSample sample;
    sample.time_s = INTAGLIO_TRY(NumberIn(table, row, "time_s", file));
    sample.command_u = INTAGLIO_TRY(NumberIn(table, row, "command", file));
    sample.position_u = INTAGLIO_TRY(NumberIn(table, row, "position", file));
    record.push_back(sample);
  }
  return record;
}

/// The answer of the identified drive to the record's command.
render::Curve AnswerOf(const drive::Drive& drive,
                       const std::vector<drive::DriveSample>& record) {
  render::Curve curve{"identified", {}};
  drive::AxisState state = drive.SettledState({record.front().command_u, 0, 0, 0});
  for (std::size_t i = 0; i < record.size(); ++i) {
    if (i > 0) {
      const double duration_s = record[i].time_s - record[i - 1].time_s;
      const double slope = (record[i].command_u - record[i - 1].command_u) / duration_s;
      state = drive.Follow(state, {record[i - 1].command_u, slope, 0, 0}, duration_s);
    }
    curve.points.emplace_back(1e3 * record[i].time_s, state.position_u);
  }
  return curve;
}

Status IdentifyAndPrint(const DriveIdentifyOptions& options) {
  const auto record = INTAGLIO_TRY(ReadRecord(options.record));
  const auto found = INTAGLIO_TRY(drive::Identify(options.kind, record));
  std::vector<double> values;
  std::string fields;
  for (const drive::IdentifiedParameter& p : found.parameters) {
    std::cout << fmt::format("{:<24} {:.6g} +- {:.2g}, 95 %\n", p.name, p.value,
                             p.interval95);
    values.push_back(p.value);
    fields += fmt::format(" {}: {:.6g}", p.name, p.value);
  }
  std::cout << fmt::format("residual                 {:.4g} rms of {} samples\n",
                           found.rms_residual_u, record.size());
  std::cout << (options.kind == "first_order"
                    ? fmt::format("profile                  stage_lag_s: {:.6g}\n",
                                  values.front())
                    : fmt::format("profile                  {} {{{} }}\n", options.kind,
                                  fields));
  if (options.picture.empty()) return {};
  render::Curve command{"command", {}}, position{"position", {}};
  for (const drive::DriveSample& s : record) {
    command.points.emplace_back(1e3 * s.time_s, s.command_u);
    position.points.emplace_back(1e3 * s.time_s, s.position_u);
  }
  const auto drive = INTAGLIO_TRY(drive::MakeDrive(options.kind, values));
  return render::WritePng(
      options.picture,
      render::DrawChart({command, position, AnswerOf(*drive, record)},
                        {"Identified drive: " + options.kind, "time, ms", "position"}));
}

int IdentifyDrive(const DriveIdentifyOptions& options) {
  if (const auto done = IdentifyAndPrint(options); !done)
    return Complain(done.error(), client::kExitWrongInput);
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
      .AddOption("record", o->record, "CSV with the columns time_s, command, position")
      .Require();
  identify.AddOption("--drive", o->kind, "kind of the profile's drive")
      .OneOf(kinds)
      .ShowDefault();
  identify.AddOption("--picture", o->picture, "PNG: the record and the identified drive");
  identify.SetFooter(
      "Example: intaglio drive identify record.csv --drive second_order\n"
      "The axis rests at the first sample. The last line is for the machine profile.\n"
      "Exit code: 0 good, 2 wrong input.");
  identify.SetAction([o] { return IdentifyDrive(*o); });
}

}  // namespace intaglio::cli
