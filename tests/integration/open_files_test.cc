// Every program with few file descriptors: an error that names the limit, before anything
// is opened, and never a signal.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

// With arguments that are understood: the limit is checked after them.
const std::vector<std::pair<std::string, std::string>> kPrograms = {
    {"intaglio", "list --domain 57"},
    {"intaglio", "materials list"},
    {"intaglio-job-service", "--domain 57 --database q.db --results jobs"},
    {"intaglio-discretizer", "--domain 57"},
    {"intaglio-sorter", "--domain 57"},
    {"intaglio-synchronizer", "--domain 57 --cell els-03 --machine els-03.textproto"},
    {"intaglio-motion-bridge", "--domain 57 --cell els-03 --machine els-03.textproto"},
    {"intaglio-marker", "--domain 57 --cell galvo --machine galvo.textproto"},
    {"intaglio-recorder", "--domain 57 --out r.mcap"},
    {"intaglio-mesh-reader", "obj model.obj"},
    {"intaglio-picture-reader", ""},
    {"virtual-engraver",
     "--truth t.textproto --laser-line l --motion-line m --glass-record g --panel p"},
};

TEST(OpenFiles, TooFewOfThemAreAnErrorThatNamesTheLimit) {
  const fs::path folder = test::FreshFolder();
  for (const auto& [name, arguments] : kPrograms) {
    // Below 5 the system itself cannot load the libraries of a program. With 7, 8, 14 and
    // 15 the DDS library ended with SIGSEGV.
    for (const int limit : {5, 6, 7, 8, 9, 13, 14, 15, 16, 20, 40}) {
      const std::string line = "cd " + folder.string() + " && ulimit -n " +
                               std::to_string(limit) + " && exec " +
                               Program(name).string() + " " + arguments;
      Running run("/bin/sh", {"-c", line}, folder / "output.txt");
      const Ended ended = run.WaitForEnd(10s);
      ASSERT_EQ(ended.exit_code, 2) << name << " with " << limit << ": " << ended.output;
      EXPECT_THAT(ended.output,
                  HasSubstr("the limit of open files is " + std::to_string(limit)))
          << name;
      EXPECT_THAT(ended.output, HasSubstr("ulimit -n 1024")) << name;
    }
  }
}

// Most systems permit more than they begin with.
TEST(OpenFiles, ALimitThatMayBeRaisedIsRaised) {
  const fs::path folder = test::FreshFolder();
  Running run(
      "/bin/sh",
      {"-c", "ulimit -S -n 14 && exec " + Program("intaglio").string() + " fonts"},
      folder / "output.txt");
  const Ended ended = run.WaitForEnd(30s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
}

}  // namespace
}  // namespace intaglio
