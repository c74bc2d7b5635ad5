#include "services/cli/preview/preview_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/job/job_limits.h"
#include "services/cli/job/job_options.h"
#include "services/cli/json/print_json.h"
#include "services/cli/preview/course_preview.h"
#include "services/cli/preview/named_job.h"
#include "services/cli/progress/late_meter.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/folder_name.h"
#include "services/client/preview/draft.h"
#include "services/client/preview/preview.h"
#include "services/client/preview/preview_text.h"
#include "services/client/proof/proof_folder.h"
#include "services/client/warning_text.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct PreviewCommandOptions {
  JobFlags job;
  ShopOfJob shop;
  std::string out, materials_db;
  bool json = false;
  AcceptFlag accept;
};

/// The job with everything resolved, and what was chosen for the user.
struct JobToPreview {
  FrozenJob frozen;
  std::vector<std::string> notes;
  Warnings of_arrangement;
};

Result<JobToPreview> FreezeNamed(const PreviewCommandOptions& options) {
  auto job = INTAGLIO_TRY(FindNamedJob(options.job, options.shop));
  if (job.job.has_marks()) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: is a job of marks; use intaglio marks preview", job.job.name()),
        job.job.name());
  }
  auto frozen = INTAGLIO_TRY(FreezeWithGlass(job, options.materials_db));
  return JobToPreview{std::move(frozen), std::move(job.notes),
                      std::move(job.of_arrangement)};
}

/// `page`: what shows it.
void Print(const JobPreview& figures, const fs::path& page) {
  std::cout << fmt::format("{:<11} {}\n", "job", figures.name());
  for (const client::PreviewLine& line : client::LinesOf(figures)) {
    std::cout << fmt::format("{:<11} {}\n", line.label, line.value);
  }
  for (const WarningRecord& warning : figures.warnings()) {
    std::cout << fmt::format("{:<11} {}\n", client::LabelOf(WarningOf(warning)),
                             warning.text());
  }
  std::cout << fmt::format("{:<11} {}\n{:<11} {}\n", "verdict",
                           client::VerdictText(figures), "page", page.string());
}

fs::path FolderOf(const PreviewCommandOptions& options, const std::string& name) {
  return options.out.empty() ? fs::path("intaglio-preview") / client::FolderNameOf(name)
                             : fs::path(options.out);
}

int PreviewOfCourse(const PreviewCommandOptions& options, const JobSpec& job) {
  const std::string name =
      job.name().empty() ? fs::path(job.course().files(0)).stem().string() : job.name();
  const fs::path folder = FolderOf(options, name);
  const auto figures = PreviewCourse(job, options.job.size_limits, folder);
  if (!figures) return Complain(figures.error());
  if (options.json) return PrintJson(*figures);
  Print(*figures, folder / kCoursePicture);
  return client::kExitGood;
}

/// A person looks at it meanwhile; what is wrong is reported by the preview.
void ShowDraft(const FrozenJob& job, const client::PreviewOptions& how,
               const fs::path& folder) {
  const auto draft = client::MakeDraft(job, how);
  if (!draft || !client::WritePreview(folder, *draft)) return;
  std::cerr << fmt::format("{}: {}\n", (folder / client::kPreviewPage).string(),
                           client::VerdictText(draft->figures));
}

int MakeAndWrite(const PreviewCommandOptions& given) {
  PreviewCommandOptions options = given;
  if (const auto taken = TakeAnswers(options.accept, options.job); !taken)
    return Complain(taken.error());
  const auto course = FindCourseJob(options.job);
  if (!course) return Complain(course.error());
  if (*course) return PreviewOfCourse(options, **course);
  options.job.kept_meshes = std::make_shared<KeptMeshes>();
  const auto job = FreezeNamed(options);
  if (!job) return Complain(job.error());
  for (const std::string& note : job->notes) std::cerr << note << "\n";
  client::PreviewOptions how;
  how.limits = LimitsOf(options.job);
  how.executor = host::AllCores();
  how.made_utc = client::UtcNow();
  how.found = job->of_arrangement;
  const fs::path folder = FolderOf(options, job->frozen.job().name());
  if (!options.json) ShowDraft(job->frozen, how, folder);
  std::optional<LateMeter> meter(std::in_place);
  const auto preview = client::MakePreview(
      job->frozen, how, [&](const char* stage, std::uint64_t done, std::uint64_t total) {
        return meter->Show(stage, done, total);
      });
  meter.reset();
  if (!preview) return Complain(preview.error());
  if (auto written = client::WritePreview(folder, *preview); !written) {
    return Complain(written.error());
  }
  if (options.json) {
    if (const int failed = PrintJson(preview->figures); failed != 0) return failed;
  } else {
    Print(preview->figures, folder / client::kPreviewPage);
  }
  return preview->figures.verdict() == client::kNeedsConsent ? client::kExitNotGood
                                                             : client::kExitGood;
}

}  // namespace

void AddPreviewCommand(command_line::Command app) {
  auto options = std::make_shared<PreviewCommandOptions>();
  command_line::Command preview = app.AddCommand(
      "preview", "show what a job will look like and take, before anything is engraved");
  preview.AddOption("JOB|MODEL", options->job.what,
                    "a job file, the number of a job in a shop, or models");
  AddJobOptions(preview, options->job);
  AddAnswers(preview, options->accept);
  preview.AddOption("--out", options->out,
                    "folder of page, picture and figures, default intaglio-preview/NAME");
  preview.AddFlag("--json", options->json, "print the figures for programs");
  preview.AddOption("--materials", options->materials_db,
                    "material base, default the user's");
  AddShopOfJob(preview, options->shop);
  preview.SetFooter(
      "Example: intaglio preview horse.stl --height 40 --block 60 60 60\n"
      "Example: intaglio preview job.textproto; intaglio preview 12\n"
      "It writes preview.html (all in one file), preview.png and preview.json.\n"
      "Exit code: 0 ready, 2 wrong input, 3 a warning has to be accepted before the "
      "arm.");
  preview.SetAction([options] { return MakeAndWrite(*options); });
}

}  // namespace intaglio::cli
