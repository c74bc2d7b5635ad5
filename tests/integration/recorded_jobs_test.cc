// Ten jobs whose points, order, plan and cracks were recorded: a change of the code that
// is not meant to change what is made leaves all four as they are, bit for bit.
// tests/data/recorded_jobs.tsv has a row for each; INTAGLIO_WRITE_GOLDEN=1 writes the
// checksums anew when a change of the output is meant (once for each row: the tests run
// as processes of their own).

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Program;
using testing::Running;
using Tokens = std::vector<std::string>;

const fs::path kTable = fs::path(INTAGLIO_SOURCE_DIR) / "tests/data/recorded_jobs.tsv";

struct RecordedJob {
  std::string name = {}, arguments = {};
  std::string cloud = {}, path = {}, plan = {},
              glass = {};  ///< CRC-32, eight hexadecimal digits
};

void PrintTo(const RecordedJob& job, std::ostream* out) { *out << job.arguments; }

std::vector<RecordedJob> ReadTable() {
  std::vector<RecordedJob> jobs;
  std::ifstream in(kTable);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream cells(line);
    RecordedJob job;
    for (std::string* cell :
         {&job.name, &job.arguments, &job.cloud, &job.path, &job.plan, &job.glass}) {
      std::getline(cells, *cell, '\t');
    }
    jobs.push_back(job);
  }
  return jobs;
}

/// The table with this row in place of the one of its name.
void WriteRow(const RecordedJob& job) {
  const std::string text = testing::TextIn(kTable);
  std::istringstream in(text);
  std::ofstream out(kTable);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(job.name + "\t")) {
      line = job.name + "\t" + job.arguments + "\t" + job.cloud + "\t" + job.path + "\t" +
             job.plan + "\t" + job.glass;
    }
    out << line << "\n";
  }
}

/// Those of the arguments that belong to making points, without order and motion.
Tokens OfPoints(const Tokens& arguments) {
  static const std::set<std::string> kOthers = {"--name", "--order", "--profile",
                                                "--rate"};
  Tokens kept;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (kOthers.contains(arguments[i])) {
      ++i;  // its value
    } else {
      kept.push_back(arguments[i]);
    }
  }
  return kept;
}

class RecordedJobs : public ::testing::TestWithParam<RecordedJob> {
 protected:
  Ended Type(Tokens words) {
    std::istringstream arguments(GetParam().arguments);
    std::string file;
    arguments >> file;
    words.insert(words.begin() + 1,
                 (fs::path(INTAGLIO_SOURCE_DIR) / "deploy/jobs" / file).string());
    Tokens options;
    for (std::string option; arguments >> option;) options.push_back(option);
    if (words.front() == "discretize") options = OfPoints(options);
    words.insert(words.end(), options.begin(), options.end());
    Running run(Program("intaglio"), words, folder_ / (words.front() + ".txt"));
    Ended ended = run.WaitForEnd(120s);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    return ended;
  }

  JobReport Engrave(const fs::path& out) {
    Type({"run", "--lockstep", "--warm-up", "0", "--no-record", "--out", out.string(),
          "--materials", (folder_ / "materials.db").string()});
    JobReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    testing::TextIn(out / "report.json"), &report)
                    .ok());
    return report;
  }

  fs::path folder_ = test::FreshFolder();
};

TEST_P(RecordedJobs, GiveWhatTheyGave) {
  JobReport report = Engrave(folder_ / "out");
  // A computer under load interrupts a run: the rest comes later, at other ticks.
  const auto interrupted = [&] {
    return report.engrave().run_count() > 1 &&
           report.checksums().at("glass") != GetParam().glass;
  };
  for (int again = 1; interrupted() && again < 4; ++again) {
    report = Engrave(folder_ / ("out" + std::to_string(again)));
  }
  const Ended discretized =
      Type({"discretize", "--out", (folder_ / "cloud.ply").string()});
  EXPECT_EQ(report.points().made(), report.points().planned());
  std::smatch cloud;
  ASSERT_TRUE(
      std::regex_search(discretized.output, cloud, std::regex("checksum ([0-9a-f]{8})")))
      << discretized.output;
  const auto& sums = report.checksums();
  const RecordedJob now{GetParam().name, GetParam().arguments, cloud[1],
                        sums.at("path"), sums.at("plan"),      sums.at("glass")};
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr) WriteRow(now);
  EXPECT_EQ(now.cloud, GetParam().cloud);
  EXPECT_EQ(now.path, GetParam().path);
  EXPECT_EQ(now.plan, GetParam().plan);
  EXPECT_EQ(now.glass, GetParam().glass);
}

INSTANTIATE_TEST_SUITE_P(InLockstep, RecordedJobs, ::testing::ValuesIn(ReadTable()),
                         [](const auto& job) { return job.param.name; });

TEST(RecordedJobsTable, HasTenRows) { EXPECT_EQ(ReadTable().size(), 10u); }

}  // namespace
}  // namespace intaglio
