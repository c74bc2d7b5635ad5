// docs/schemas holds a schema of each JSON that a command writes, as it follows from the
// messages. INTAGLIO_WRITE_GOLDEN=1 writes them; tests/integration/scripts_test.py
// validates what the commands really write.

#include "tests/services/cli/schemas/json_schema.h"

#include <gmock/gmock.h>
#include <google/protobuf/compiler/importer.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

namespace intaglio::schemas {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;
using ::testing::HasSubstr;

const fs::path kFolder = fs::path(INTAGLIO_SOURCE_DIR) / "docs/schemas";

class Errors : public pb::compiler::MultiFileErrorCollector {
  void AddError(const std::string& file, int line, int,
                const std::string& message) override {
    ADD_FAILURE() << file << ":" << line + 1 << ": " << message;
  }
};

/// The messages with their comments, which compiled descriptors do not have.
class Protos {
 public:
  Protos() {
    tree_.MapPath("", INTAGLIO_SOURCE_DIR);
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
    {"status", "`intaglio status --json`", "shop", "ShopStatus"},
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
    {"stop_answer", "POST /api/v1/stop of the console", "console", "StopAnswer"},
    {"hold_answer", "POST /api/v1/jobs/N/hold of the console", "console", "HoldAnswer"},
    {"command_answer",
     "POST /api/v1/jobs/N/arm, resume, pause, cancel, speed of the console", "console",
     "CommandAnswer"},
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

std::string TextIn(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The file is the schema, or becomes it.
void Compare(const std::string& name, const Json& schema) {
  const fs::path file = kFolder / (name + ".schema.json");
  const std::string text = schema.Text() + "\n";
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr) {
    fs::create_directories(kFolder);
    std::ofstream(file, std::ios::binary) << text;
  }
  EXPECT_TRUE(TextIn(file) == text)
      << file << " is not what follows from the messages: write it with "
      << "INTAGLIO_WRITE_GOLDEN=1";
}

TEST(JsonSchemas, AreThoseOfTheMessagesThatCommandsWrite) {
  Protos protos;
  std::set<std::string> names;
  for (const Written& written : kWritten) {
    Compare(written.name,
            SchemaOf({written.name, written.title,
                      &protos.Message(written.file, written.message), written.fields}));
    names.insert(std::string(written.name) + ".schema.json");
  }
  const auto& material = protos.Message("material", "MaterialRecord");
  const auto& optics = protos.Message("material", "OpticalValuesRecord");
  const auto& focus = protos.Message("material", "PulseFocusRecord");
  Compare("glass", GlassSchema("glass", "`intaglio materials show --json`", material,
                               optics, &focus, false));
  Compare("glasses", GlassSchema("glasses", "`intaglio materials list --json`", material,
                                 optics, nullptr, true));
  names.insert({"glass.schema.json", "glasses.schema.json"});
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    EXPECT_TRUE(names.contains(entry.path().filename().string())) << entry.path();
  }
  const std::string document = TextIn(INTAGLIO_SOURCE_DIR "/docs/cli.md");
  for (const std::string& name : names) {
    EXPECT_THAT(document, HasSubstr("schemas/" + name));
  }
}

TEST(JsonSchemas, RequireWhatIsAlwaysWrittenAndGiveTheComments) {
  Protos protos;
  const std::string text =
      SchemaOf({"event", "", &protos.Message("shop", "JobEvent")}).Text();
  EXPECT_THAT(text, HasSubstr("\"required\": [\n    \"time\","));
  EXPECT_THAT(text, HasSubstr("\"description\": \"UTC, ISO 8601, ms\""));
  EXPECT_THAT(text,
              HasSubstr("\"$schema\": \"https://json-schema.org/draft/2020-12/schema\""));
}

}  // namespace
}  // namespace intaglio::schemas
