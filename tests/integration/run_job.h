#pragma once

// `intaglio run` on a supplied job, as a user types it, with its separate processes.

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "engrave/formats/glass_record.h"
#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::testing {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

inline constexpr auto kBound = 60s;

inline fs::path SampleJob() {
  return fs::path(INTAGLIO_SOURCE_DIR) / "deploy/jobs/sample.textproto";
}

class RunJob : public ::testing::Test {
 protected:
  RunJob() : folder_(test::FreshFolder()) {}

  std::vector<std::string> Arguments(std::vector<std::string> more,
                                     const fs::path& job = SampleJob()) const {
    std::vector<std::string> words = {"run",         job.string(),
                                      "--out",       (folder_ / "out").string(),
                                      "--materials", (folder_ / "materials.db").string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Ended Run(std::vector<std::string> more) {
    Running run(Program("intaglio"), Arguments(std::move(more)), folder_ / "output.txt");
    return run.WaitForEnd(kBound);
  }
  JobReport Report() const {
    JobReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    TextIn(folder_ / "out/report.json"), &report)
                    .ok());
    return report;
  }
  /// Waits until the machine has made some cracks; true when it has.
  bool AwaitCracks(std::size_t count) const {
    return Eventually(
        [&] {
          const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
          return glass && glass->cracks.size() >= count;
        },
        30s);
  }
  std::string Press(const std::string& command) const {
    return AskPanel(folder_ / "out/session", command);
  }
  /// Nothing of this run is left: neither services nor the machine.
  bool NothingLeft() const {
    return Eventually([&] { return ProcessesWith({(folder_ / "out").string()}).empty(); },
                      10s);
  }

  fs::path folder_;
};

}  // namespace intaglio::testing
