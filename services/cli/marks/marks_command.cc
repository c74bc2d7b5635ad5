#include "services/cli/marks/marks_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <iterator>
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
#include "services/cli/terminal/interrupt.h"
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
#include "services/job/marks/dot_rows.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/planned_marks.h"
#include "services/job/marks/web_run.h"
#include "services/job/models/program_limits.h"
#include "services/job/models/text_model.h"
#include "services/platform/command_line/supplied_files.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

constexpr double kPictureFields = 3;  // a web of a thousand repeats is a thin line
constexpr std::size_t kMaxNamed = 10;

struct MarksPreviewOptions {
  std::string job_file, machine, picture, csv;
  std::vector<std::string> fields;  // "PATH=VALUE"
  double size_limits = 1;
};

/// What the job becomes.
struct MarksPreview {
  JobSpec job;
  MachineSpec machine;
  PlannedMarks marks;
  Warnings warnings;

  /// Marks at the speed that the job asks for, ascending.
  std::vector<std::size_t> missed() const {
    const auto& web = marks.web();
    return web && *web ? (*web)->missed : std::vector<std::size_t>();
  }
  /// That print marks are seen early enough.
  Status eye() const {
    const auto& web = marks.web();
    return web && *web ? CheckEyeWay(job, machine, **web) : Status();
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

Result<MarksPreview> PlanMarks(const MarksPreviewOptions& options) {
  auto built = INTAGLIO_TRY(ReadMarks(options));
  const ReadLimits limits = mesh_reader::LimitsOfProgram(options.size_limits);
  auto files = INTAGLIO_TRY(ReadJobMarkFiles(built.job, limits));
  LateMeter meter;
  const auto show = [&meter](const char* stage, const char* things) -> ProgressSink {
    return [&meter, stage, things](std::uint64_t done, std::uint64_t total) {
      return meter.Show(stage, done, total, things) && Interrupts() == 0;
    };
  };
  Warnings warnings;
  auto marks = INTAGLIO_TRY(PlannedMarks::Make(
      built.job, built.machine, std::move(files), limits, host::AllCores(), warnings,
      {show("marks", "repeats"), show("order", nullptr)}));
  return MarksPreview{std::move(built.job), std::move(built.machine), std::move(marks),
                      std::move(warnings)};
}

/// Each name once, in the order of marking.
Result<std::string> NamesOfMissed(MarksPreview& preview) {
  const std::vector<std::size_t> missed = preview.missed();
  std::vector<std::string> names;
  bool more = false;
  auto next = missed.begin();
  INTAGLIO_TRY(preview.marks.ForEach([&](std::size_t number, const mark::Mark& mark) {
    if (next == missed.end()) return false;
    if (number != *next) return true;
    ++next;
    std::string name = NameOfMark(preview.job, preview.marks.pens(), mark);
    if (std::ranges::find(names, name) != names.end()) return true;
    more = names.size() == kMaxNamed;
    if (!more) names.push_back(std::move(name));
    return !more;
  }));
  return fmt::format("{}{}", fmt::join(names, ", "), more ? ", and more" : "");
}

Result<std::vector<std::string>> WebLines(MarksPreview& preview) {
  const Result<WebRun>& web = *preview.marks.web();
  std::vector<std::string> lines;
  if (!web) return std::vector<std::string>{"web         " + web.error().message};
  const double max_mm_s = web->max_mm_s;
  lines.push_back(fmt::format("web         at most {:.1f} mm/s", max_mm_s));
  const double pitch_mm = preview.job.marks().repeats().pitch_mm();
  if (pitch_mm > 0)
    lines.back() += fmt::format(", {:.4g} repeats a minute", 60 * max_mm_s / pitch_mm);
  const double asked_mm_s = preview.job.marks().web().speed_mm_s();
  if (web->eye_max_mm_s) lines.push_back("print       " + PrintMarksText(preview.job));
  if (const auto seen = preview.eye(); !seen) {
    lines.push_back("verdict     " + seen.error().message);
  } else if (asked_mm_s == 0) {
    lines.push_back("verdict     good: the web runs as fast as all marks can be made");
  } else if (web->missed.empty()) {
    lines.push_back(
        fmt::format("verdict     good: all marks are made at {:.6g} mm/s", asked_mm_s));
  } else {
    const std::string names = INTAGLIO_TRY(NamesOfMissed(preview));
    lines.push_back(
        fmt::format("verdict     at {:.6g} mm/s {} of {} would be missed: {}; reduce "
                    "marks.web.speed_mm_s to {:.1f}",
                    asked_mm_s, web->missed.size(),
                    Counted(preview.marks.mark_count(), "mark"), names, max_mm_s));
  }
  return lines;
}

Result<std::vector<std::string>> LinesOfMarks(MarksPreview& preview) {
  const PlannedMarks& marks = preview.marks;
  const MarkTimes& times = marks.times();
  std::vector<std::string> lines = {
      fmt::format("job         {}", preview.job.name()),
      fmt::format("marks       {}, {:.4g} m long with all passes", marks.mark_count(),
                  times.mark_mm / 1000),
      fmt::format("jumps       {:.4g} m", times.jump_mm / 1000),
      fmt::format("time        {:.3f} s of marking and jumps", times.time_s)};
  if (!marks.head().window.is_whole_field()) {
    lines.push_back(fmt::format("field       {:.4g} mm{}", marks.head().field_mm(),
                                NarrowedText(marks.head().window)));
  }
  for (std::size_t i = 0; i < marks.pens().size(); ++i) {
    const mark::Pen& pen = marks.pens()[i];
    lines.push_back(fmt::format(
        "{:<12}{}, {:.6g} mm/s, {:.4g} of the power, {:.6g} "
        "Hz, {}",
        pen.name, Counted(marks.counts()[i], "mark"), pen.speed_mm_s, pen.power_ratio,
        pen.frequency_hz, Counted(pen.pass_count, "pass", "passes")));
    const MarkItem& item = preview.job.marks().items(static_cast<int>(i));
    if (const std::string how = DotModeText(item, preview.machine); !how.empty()) {
      lines.push_back(fmt::format("{:<12}{} of {}, {}", "dots", marks.way_counts()[i],
                                  pen.name, how));
    }
  }
  for (const Warning& warning : preview.warnings)
    lines.push_back(client::WarningLine(warning));
  if (marks.web()) {
    auto of_web = INTAGLIO_TRY(WebLines(preview));
    std::ranges::move(of_web, std::back_inserter(lines));
  } else {
    lines.push_back("verdict     good: all marks lie in the field");
  }
  return lines;
}

/// The first fields of a web, or the whole piece; what lies at the right arrives first.
Status DrawMarks(MarksPreview& preview, const std::string& file,
                 const std::vector<std::string>& lines) {
  render::WebPicture picture;
  picture.field_mm = preview.marks.head().field_mm();
  picture.title = preview.job.name();
  picture.figures = lines;
  const std::vector<std::size_t> missed = preview.missed();
  INTAGLIO_TRY(preview.marks.ForEach(
      [&](std::size_t number, const mark::Mark& mark) {
        const bool is_missed = std::ranges::binary_search(missed, number);
        for (std::vector<Vec2>& way : mark::LitWaysOf(mark, 0.01)) {
          for (Vec2& p : way) p.x() -= mark.web_mm;
          picture.marks_mm.push_back(std::move(way));
          picture.missed.push_back(is_missed);
        }
        return true;
      },
      kPictureFields * picture.field_mm));
  return render::WritePng(file, render::DrawWeb(picture));
}

Status WriteMarks(MarksPreview& preview, const std::string& path) {
  auto file = INTAGLIO_TRY(io::AtomicFile::Create(path));
  INTAGLIO_TRY(file.Write(std::string_view("mark,item,web_mm,closed,x_mm,y_mm,dark\n")));
  Status written;
  LateMeter meter;
  const std::size_t count = preview.marks.mark_count();
  INTAGLIO_TRY(preview.marks.ForEach([&](std::size_t number, const mark::Mark& mark) {
    meter.Show("csv", number, count, "marks");
    std::string rows;
    const bool is_row = mark::IsRow(mark);
    const auto places = mark::PlacesOf(mark, 0.001);
    for (std::size_t i = 0; i < places.size(); ++i) {
      fmt::format_to(std::back_inserter(rows), "{},{},{},{},{:.6g},{:.6g},{}\n",
                     number + 1, mark.pen + 1, mark.web_mm, mark.closed ? 1 : 0,
                     places[i].x(), places[i].y(), is_row && mark.places[i].dark ? 1 : 0);
    }
    written = Interrupts() == 0 ? file.Write(rows)
                                : Fail(ErrorCode::kCancelled, "the CSV was cancelled");
    return written.has_value();
  }));
  INTAGLIO_TRY(written);
  return file.Commit();
}

Result<bool> PreviewMarks(const MarksPreviewOptions& options) {
  auto preview = INTAGLIO_TRY(PlanMarks(options));
  const auto lines = INTAGLIO_TRY(LinesOfMarks(preview));
  for (const std::string& line : lines) std::cout << line << "\n";
  if (!options.csv.empty()) INTAGLIO_TRY(WriteMarks(preview, options.csv));
  if (!options.picture.empty()) INTAGLIO_TRY(DrawMarks(preview, options.picture, lines));
  return preview.missed().empty() && preview.eye().has_value();
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
      "Exit code: 0 good, 2 wrong input, 3 marks are missed at the speed of the web, 5 "
      "cancelled.");
  preview.SetAction([o]() -> int {
    CatchInterrupts();
    const auto good = PreviewMarks(*o);
    if (!good && good.error().code == ErrorCode::kCancelled)
      return Complain(good.error(), client::kExitCancelled);
    if (!good) return Complain(good.error(), client::kExitWrongInput);
    return *good ? client::kExitGood : client::kExitNotGood;
  });
}

}  // namespace intaglio::cli
