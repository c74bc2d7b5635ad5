#include "services/cli/marks/marks_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/png_file.h"
#include "engrave/render/web/web_picture.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_options.h"
#include "services/cli/progress/late_meter.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/warning_text.h"
#include "services/job/checks/job_check.h"
#include "services/job/checks/marks_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/fields/field_path.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/files/job_file.h"
#include "services/job/head/head_correction.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/web_run.h"
#include "services/job/models/program_limits.h"
#include "services/job/models/text_model.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

constexpr double kPictureFields = 3;  // a web of a thousand repeats is a thin line
constexpr std::size_t kMaxNamed = 10;

struct MarksPreviewOptions {
  std::string job_file, machine, picture, csv;
  std::vector<std::string> fields;  // "PATH=VALUE"
  double size_limits = 1;
};

/// What the job becomes, in the order in which it is made.
struct OrderedMarks {
  JobSpec job;
  HeadFigures head;
  mark::MarkSet set;
  Result<WebRun> web;  ///< of a job with a web
  Warnings warnings;

  /// Marks at the speed that the job asks for.
  std::vector<std::size_t> missed() const {
    return web ? web->missed : std::vector<std::size_t>();
  }
};

struct MarksOnHead {
  JobSpec job;
  MachineSpec machine;
};

Status SetMarkFields(const std::vector<std::string>& fields, JobSpec& job) {
  for (const std::string& field : fields) {
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--set: \"{}\" has no =; write it as "
                              "marks.web.speed_mm_s=250",
                              field),
                  field);
    }
    const auto set = SetField(job, field.substr(0, equals), field.substr(equals + 1));
    if (!set) {
      return Fail(set.error().code, "--set: " + set.error().message, set.error().value);
    }
  }
  return {};
}

/// All that is wrong with the two, one a line. Nothing but the head is needed of the
/// machine: its line need not be there yet.
Result<MarksOnHead> ReadMarks(const MarksPreviewOptions& options) {
  MarksOnHead read;
  read.job = INTAGLIO_TRY(ReadJobFile(INTAGLIO_TRY(
      command_line::FindSupplied(options.job_file, command_line::kSuppliedJobs))));
  INTAGLIO_TRY(SetMarkFields(options.fields, read.job));
  if (!read.job.has_marks()) {
    return Fail(ErrorCode::kMissing,
                options.job_file +
                    ": has no marks; preview a job that engraves points "
                    "by intaglio preview",
                options.job_file);
  }
  if (!options.machine.empty()) read.job.set_machine_file(options.machine);
  std::vector<Finding> found = ResolveFonts(read.job);
  for (Finding& finding : CheckMarks(read.job)) found.push_back(std::move(finding));
  if (!found.empty()) return tl::unexpected(JoinErrors(found));
  const auto file = INTAGLIO_TRY(FindMachineFile(read.job.machine_file()));
  read.machine = INTAGLIO_TRY(ReadUncheckedMachine(file));
  if (read.machine.has_scan_head())
    CheckRanges(read.machine.scan_head(), "machine.scan_head", found);
  for (Finding& finding : CheckMarksOnMachine(read.job, read.machine))
    found.push_back(std::move(finding));
  if (!found.empty()) return tl::unexpected(JoinErrors(found));
  read.job = WithDefaults(std::move(read.job), read.machine);
  return read;
}

Result<OrderedMarks> OrderMarksOf(const MarksPreviewOptions& options) {
  auto built = INTAGLIO_TRY(ReadMarks(options));
  const ReadLimits limits = mesh_reader::LimitsOfProgram(options.size_limits);
  auto files = INTAGLIO_TRY(ReadJobMarkFiles(built.job, limits));
  OrderedMarks ordered;
  LateMeter meter;
  const auto show = [&meter](const char* stage) -> ProgressSink {
    return [&meter, stage](std::uint64_t done, std::uint64_t total) {
      return meter.Show(stage, done, total);
    };
  };
  auto made = INTAGLIO_TRY(MakeJobMarks(built.job, built.machine, std::move(files),
                                        limits, ordered.warnings, show("marks")));
  ordered.set = INTAGLIO_TRY(
      OrderJobMarks(built.job, built.machine, std::move(made), show("order")));
  ordered.head = HeadFiguresOf(built.machine);
  ordered.job = std::move(built.job);
  if (ordered.job.marks().has_web())
    ordered.web = WebRunOf(ordered.job, built.machine, ordered.set);
  return ordered;
}

/// Each name once, in the order of marking.
std::string NamesOfMissed(const OrderedMarks& marks) {
  std::vector<std::string> names;
  for (const std::size_t number : marks.web->missed) {
    std::string name = NameOfMark(marks.job, marks.set, number);
    if (std::ranges::find(names, name) != names.end()) continue;
    if (names.size() == kMaxNamed)
      return fmt::format("{}, and more", fmt::join(names, ", "));
    names.push_back(std::move(name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::string> WebLines(const OrderedMarks& marks) {
  std::vector<std::string> lines;
  if (!marks.web) return {"web         " + marks.web.error().message};
  const double max_mm_s = marks.web->max_mm_s;
  lines.push_back(fmt::format("web         at most {:.1f} mm/s", max_mm_s));
  const double pitch_mm = marks.job.marks().repeats().pitch_mm();
  if (pitch_mm > 0)
    lines.back() += fmt::format(", {:.4g} repeats a minute", 60 * max_mm_s / pitch_mm);
  const double asked_mm_s = marks.job.marks().web().speed_mm_s();
  if (asked_mm_s == 0) {
    lines.push_back("verdict     good: the web runs as fast as all marks can be made");
  } else if (marks.web->missed.empty()) {
    lines.push_back(
        fmt::format("verdict     good: all marks are made at {:.6g} mm/s", asked_mm_s));
  } else {
    lines.push_back(fmt::format(
        "verdict     at {:.6g} mm/s {} of {} would be missed: {}; reduce "
        "marks.web.speed_mm_s to {:.1f}",
        asked_mm_s, marks.web->missed.size(), Counted(marks.set.marks.size(), "mark"),
        NamesOfMissed(marks), max_mm_s));
  }
  return lines;
}

std::vector<std::string> LinesOfMarks(const OrderedMarks& marks) {
  const MarkTimes times = marks.job.marks().has_web() && marks.web
                              ? marks.web->times
                              : TimesOf(marks.set, marks.head);
  std::vector<std::string> lines = {
      fmt::format("job         {}", marks.job.name()),
      fmt::format("marks       {}, {:.4g} m long with all passes", marks.set.marks.size(),
                  times.mark_mm / 1000),
      fmt::format("jumps       {:.4g} m", times.jump_mm / 1000),
      fmt::format("time        {:.3f} s of marking and jumps", times.time_s)};
  if (!marks.head.window.is_whole_field()) {
    lines.push_back(fmt::format("field       {:.4g} mm{}", marks.head.field_mm(),
                                NarrowedText(marks.head.window)));
  }
  for (std::size_t i = 0; i < marks.set.pens.size(); ++i) {
    const mark::Pen& pen = marks.set.pens[i];
    const auto count = std::ranges::count(marks.set.marks, static_cast<std::uint32_t>(i),
                                          &mark::Mark::pen);
    lines.push_back(fmt::format(
        "{:<12}{}, {:.6g} mm/s, {:.4g} of the power, {:.6g} "
        "Hz, {}",
        pen.name, Counted(static_cast<std::uint64_t>(count), "mark"), pen.speed_mm_s,
        pen.power_ratio, pen.frequency_hz, Counted(pen.pass_count, "pass", "passes")));
  }
  for (const Warning& warning : marks.warnings)
    lines.push_back(client::WarningLine(warning));
  if (marks.job.marks().has_web()) {
    for (std::string& line : WebLines(marks)) lines.push_back(std::move(line));
  } else {
    lines.push_back("verdict     good: all marks lie in the field");
  }
  return lines;
}

/// The first fields of a web, or the whole piece; what lies at the right arrives first.
Status DrawMarks(const OrderedMarks& marks, const std::string& file,
                 const std::vector<std::string>& lines) {
  render::WebPicture picture;
  picture.field_mm = marks.head.field_mm();
  picture.title = marks.job.name();
  picture.figures = lines;
  const double end_mm = kPictureFields * marks.head.field_mm();
  const std::vector<std::size_t> all_missed = marks.missed();
  std::size_t next_missed = 0;
  for (std::size_t i = 0; i < marks.set.marks.size(); ++i) {
    const mark::Mark& mark = marks.set.marks[i];
    const bool missed = next_missed < all_missed.size() && all_missed[next_missed] == i;
    if (missed) ++next_missed;
    if (mark.web_mm > end_mm) continue;
    std::vector<Vec2> outline = mark::PlacesOf(mark, 0.01);
    if (mark.closed) outline.push_back(outline.front());
    for (Vec2& p : outline) p.x() -= mark.web_mm;
    picture.marks_mm.push_back(std::move(outline));
    picture.missed.push_back(missed);
  }
  return render::WritePng(file, render::DrawWeb(picture));
}

Status WriteMarks(const OrderedMarks& marks, const std::string& file) {
  std::string text = "mark,item,web_mm,closed,x_mm,y_mm\n";
  for (std::size_t i = 0; i < marks.set.marks.size(); ++i) {
    const mark::Mark& mark = marks.set.marks[i];
    for (const Vec2& p : mark::PlacesOf(mark, 0.001))
      text += fmt::format("{},{},{},{},{:.6g},{:.6g}\n", i + 1, mark.pen + 1, mark.web_mm,
                          mark.closed ? 1 : 0, p.x(), p.y());
  }
  return io::WriteFileAtomically(file, std::string_view(text));
}

Result<bool> PreviewMarks(const MarksPreviewOptions& options) {
  const auto marks = INTAGLIO_TRY(OrderMarksOf(options));
  const std::vector<std::string> lines = LinesOfMarks(marks);
  for (const std::string& line : lines) std::cout << line << "\n";
  if (!options.csv.empty()) INTAGLIO_TRY(WriteMarks(marks, options.csv));
  if (!options.picture.empty()) INTAGLIO_TRY(DrawMarks(marks, options.picture, lines));
  return marks.missed().empty();
}

}  // namespace

void AddMarksCommand(command_line::Command app) {
  auto o = std::make_shared<MarksPreviewOptions>();
  command_line::Command marks = app.AddCommand("marks", "jobs of a scan head");
  marks.RequireCommand();
  marks.SetFooter("Example: intaglio marks preview label.textproto --picture label.png");
  command_line::Command preview = marks.AddCommand(
      "preview", "what a scan head will mark, how long it takes, how fast a web may run");
  preview.AddOption("JOB", o->job_file, "job file with marks").Require();
  preview.AddOption("--machine", o->machine,
                    "profile of a machine with a scan head, a name or a file");
  preview
      .AddOption("--set", o->fields,
                 "a field of the job by its path: --set marks.web.speed_mm_s=250; again "
                 "for each field")
      .TakeOneAtATime();
  preview.AddOption("--picture", o->picture, "PNG: the marks in their order");
  preview.AddOption("--csv", o->csv, "the marks in their order, a row for each place");
  AddSizeLimitsFlag(preview, o->size_limits);
  preview.SetFooter(
      "Example: intaglio marks preview label.textproto --picture label.png\n"
      "Example: intaglio marks preview label.textproto --set marks.web.speed_mm_s=250\n"
      "Exit code: 0 good, 2 wrong input, 3 marks are missed at the speed of the web.");
  preview.SetAction([o]() -> int {
    const auto good = PreviewMarks(*o);
    if (!good) return Complain(good.error(), client::kExitWrongInput);
    return *good ? client::kExitGood : client::kExitNotGood;
  });
}

}  // namespace intaglio::cli
