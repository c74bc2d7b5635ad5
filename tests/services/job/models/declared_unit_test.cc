// The unit that a file declares, and that of the job in its place.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "engrave/io/whole_file.h"
#include "services/job/job_defaults.h"
#include "services/job/model_kind.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;

class DeclaredUnit : public testing::Test {
 protected:
  /// A line of one unit, of a file whose $INSUNITS is `declared`.
  JobSources SourcesOf(const std::string& declared, std::optional<double> unit_mm) {
    std::ofstream(file_) << "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n"
                         << declared
                         << "\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n"
                            "20\n0\n11\n1\n21\n0\n0\nENDSEC\n0\nEOF\n";
    JobSpec job = GoodJob();
    job.mutable_models(0)->Clear();
    job.mutable_models(0)->set_file(file_);
    if (unit_mm) job.mutable_models(0)->mutable_placement()->set_unit_mm(*unit_mm);
    const JobSpec whole = WithDefaults(job, GoodMachine());
    const std::string text = io::ReadWholeFile(file_, 1 << 20).value();
    const auto view = std::as_bytes(std::span(text));
    std::vector<FileBytes> bytes(FilesOf(whole).size(), {view.begin(), view.end()});
    auto made = MakeSources(whole, std::move(bytes), {}, {});
    if (made) return std::move(*made);
    ADD_FAILURE() << made.error().message;
    return {};
  }
  static double LengthOf(const JobSources& made) {
    return made.sources.empty() ? 0 : made.sources.front()->Bounds().size_mm().x();
  }

  const std::string file_ =
      testing::TempDir() + "/declared_unit_" + std::to_string(::getpid()) + ".dxf";
};

TEST_F(DeclaredUnit, OfADrawingIsAppliedOnce) {
  EXPECT_NEAR(LengthOf(SourcesOf("1", {})), 25.4, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOf("0", {})), 1, 1e-6);
  EXPECT_NEAR(LengthOf(SourcesOf("0", 7)), 7, 1e-6);
}

TEST_F(DeclaredUnit, IsReplacedByThatOfTheJobWithANote) {
  const JobSources made = SourcesOf("1", 7);
  EXPECT_NEAR(LengthOf(made), 7, 1e-6) << "and not 177.8";
  EXPECT_THAT(made.warnings, Contains(Field(&Warning::text, HasSubstr("$INSUNITS"))));
  EXPECT_NEAR(LengthOf(SourcesOf("1", 1)), 1, 1e-6);
}

TEST_F(DeclaredUnit, ThatIsUnknownNeedsTheOneOfTheJob) {
  EXPECT_NEAR(LengthOf(SourcesOf("25", 7)), 7, 1e-6);
}

}  // namespace
}  // namespace intaglio
