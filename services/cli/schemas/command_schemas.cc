#include "services/cli/schemas/command_schemas.h"

#include <fmt/format.h>
#include <google/protobuf/compiler/importer.h>

#include <stdexcept>

#include "services/cli/schemas/json_schema.h"

namespace intaglio::schemas {
namespace {

namespace pb = google::protobuf;

class Errors : public pb::compiler::MultiFileErrorCollector {
  void AddError(const std::string& file, int line, int,
                const std::string& message) override {
    throw std::runtime_error(fmt::format("{}:{}: {}", file, line + 1, message));
  }
};

/// The messages with their comments, which compiled descriptors do not have.
class Protos {
 public:
  explicit Protos(const std::filesystem::path& source_dir) {
    tree_.MapPath("", source_dir.string());
    tree_.MapPath("", "/usr/include");
  }
  /// Finds a message of the file proto/FILE.proto.
  const pb::Descriptor& Message(const std::string& file, const std::string& name) {
    const auto* imported = importer_.Import("proto/" + file + ".proto");
    const auto* message =
        imported == nullptr ? nullptr : imported->FindMessageTypeByName(name);
    if (message == nullptr) throw std::runtime_error("no message " + name);
    return *message;
  }

 private:
  Errors errors_;
  pb::compiler::DiskSourceTree tree_;
  pb::compiler::Importer importer_{&tree_, &errors_};
};

struct Written {
  const char* name;
  const char* title;
  const char* file;
  const char* message;
  Fields fields = Fields::kWritten;
};

constexpr Written kWritten[] = {
    {"report", "report.json of `intaglio run`; `intaglio verify --json`", "report",
     "JobReport"},
    {"plan", "`intaglio sort --json` and `intaglio plan --json`", "plan_report",
     "PlanReport"},
    {"machine_measurement", "`intaglio machine measure --json`", "machine_report",
     "MachineMeasurement"},
    {"machine_check", "`intaglio machine check --json`", "machine_report",
     "MachineCheck"},
    {"machine_comparison", "`intaglio machine compare --json`", "machine_report",
     "MachineComparison"},
    {"drive_sizes", "`intaglio drive size --json`", "drive_report", "DriveSizes"},
    {"drive_loops", "`intaglio drive tune --json` and `intaglio drive compare --json`",
     "drive_report", "DriveLoops"},
    {"drive_simulation", "`intaglio drive simulate --json`", "drive_report",
     "DriveSimulation"},
    {"drive_course", "`intaglio drive simulate --circle --json`, and of `--corner`",
     "drive_report", "DriveCourse"},
    {"drive_identification", "`intaglio drive identify --json`", "drive_report",
     "DriveIdentification"},
    {"course_plan", "`intaglio course plan --json`", "drive_report", "CoursePlan"},
    {"quality", "`intaglio measure --json`", "quality", "CloudQuality"},
    {"preview", "preview.json; `intaglio preview --json`", "preview", "JobPreview"},
    {"cloud", "`intaglio discretize --json`", "listing", "CloudRecord"},
    {"event", "a line of --events", "shop", "JobEvent"},
    {"jobs", "`intaglio list --json`", "listing", "JobList"},
    {"job", "`intaglio show --json`", "listing", "JobRecord"},
    {"history", "`intaglio history --json`", "shop", "JobHistory"},
    {"worker_history", "`intaglio history --workers --json`", "shop", "WorkerHistory"},
    {"workers", "`intaglio workers --json`", "shop", "WorkerList"},
    {"status", "`intaglio status --json`", "shop", "ShopStatus"},
    {"fonts", "`intaglio fonts --json`", "lists", "FontList"},
    {"logs", "`intaglio logs --json`", "lists", "LogList"},
    {"console_state", "the WebSocket /control of the console", "console", "ConsoleState"},
    {"console_session", "POST /api/v1/login of the console", "console", "ConsoleSession"},
    {"log_in_request", "the body of POST /api/v1/login of the console", "console",
     "LogInRequest", Fields::kRead},
    {"stop_request", "the body of POST /api/v1/stop of the console", "console",
     "StopRequest", Fields::kRead},
    {"hold_request", "the body of POST /api/v1/jobs/N/hold of the console", "console",
     "HoldRequest", Fields::kRead},
    {"arm_request", "the body of POST /api/v1/jobs/N/arm of the console", "console",
     "ArmRequest", Fields::kRead},
    {"resume_request", "the body of POST /api/v1/jobs/N/resume of the console", "console",
     "ResumeRequest", Fields::kRead},
    {"speed_request", "the body of POST /api/v1/jobs/N/speed of the console", "console",
     "SpeedRequest", Fields::kRead},
    {"move_request", "the body of POST /api/v1/jobs/N/move of the console", "console",
     "MoveRequest", Fields::kRead},
    {"reset_request", "the body of POST /api/v1/machines/CELL/reset of the console",
     "console", "ResetRequest", Fields::kRead},
    {"stop_answer", "POST /api/v1/stop of the console", "console", "StopAnswer"},
    {"hold_answer", "POST /api/v1/jobs/N/hold of the console", "console", "HoldAnswer"},
    {"command_answer",
     "a command with `--json` and no message of its own, and what is refused with "
     "`--json`; POST /api/v1/jobs/N/arm, resume, pause, cancel, speed of the console",
     "console", "CommandAnswer"},
    {"job_choices", "GET /api/v1/choices of the console", "console", "JobChoices"},
    {"machine_teaching", "GET /api/v1/machines/CELL/teaching of the console", "console",
     "MachineTeaching"},
    {"series_zero_move", "GET /api/v1/machines/CELL/zero_move of the console", "console",
     "SeriesZeroMove"},
    {"test_job_request",
     "the body of POST /api/v1/machines/CELL/pulse and focus of the console", "console",
     "TestJobRequest", Fields::kRead},
    {"upload_answer", "POST /api/v1/submissions/ID/files/FILE of the console", "console",
     "UploadAnswer"},
    {"submit_answer", "POST /api/v1/submissions/ID of the console", "console",
     "SubmitAnswer"},
    {"console_error",
     "what the console refuses, where a request has no answer of its own", "console",
     "ConsoleError"},
    {"statistics", "statistics.json in the folder of a job", "shop", "JobStatistics"},
    {"stages", "stages.json in the folder of a shop's job", "report", "JobStages"},
    {"batch_results", "--results of `intaglio batch`", "shop", "BatchResults"},
    {"teach_status", "`intaglio teach status --json`", "teach", "TeachStatus"},
    {"teach_history", "`intaglio teach history --json`", "teach", "TaughtHistoryRecord"},
    {"recording_info", "`intaglio recording info --json`", "recording", "RecordingInfo"},
    {"recording_channels", "`intaglio recording list --json`", "recording",
     "RecordingChannels"},
    {"replay_comparison", "`intaglio replay --against --json`", "replay",
     "ReplayComparison"},
    {"job_file", "a job file (.json)", "job", "JobSpec", Fields::kRead}};

}  // namespace

std::map<std::string, std::string> CommandSchemas(
    const std::filesystem::path& source_dir) {
  Protos protos(source_dir);
  std::map<std::string, std::string> schemas;
  const auto add = [&](const std::string& name, const Json& schema) {
    schemas[name + ".schema.json"] = schema.Text() + "\n";
  };
  for (const Written& written : kWritten) {
    add(written.name,
        SchemaOf({written.name, written.title,
                  &protos.Message(written.file, written.message), written.fields}));
  }
  const auto& material = protos.Message("material", "MaterialRecord");
  const auto& optics = protos.Message("material", "OpticalValuesRecord");
  const auto& focus = protos.Message("material", "PulseFocusRecord");
  add("glass", GlassSchema("glass", "`intaglio materials show --json`", material, optics,
                           &focus, false));
  add("glasses", GlassSchema("glasses", "`intaglio materials list --json`", material,
                             optics, nullptr, true));
  return schemas;
}

}  // namespace intaglio::schemas
