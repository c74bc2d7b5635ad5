// What a batch checks before its first job is submitted.

#include "services/cli/batch/batch_jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class BatchJobsTest : public ::testing::Test {
 protected:
  BatchJobsTest() : folder_(test::FreshFolder()) {
    fs::copy_file(INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.obj", folder_ / "sample.obj");
  }
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  /// A job of the supplied model; `rest` are more fields.
  void WriteJob(const std::string& rest) const {
    Write("job.textproto",
          "name: \"knot\" discretization { min_spacing_mm: 0.3 }\n"
          "models { file: \"sample.obj\" placement { fit_height_mm: 22 } }\n"
          "block { size_mm { x: 50 y: 50 z: 30 } }\n" +
              rest);
  }
  Result<std::vector<BatchJob>> Build(const std::string& table) const {
    BatchSource source;
    source.file = Write("batch.csv", table);
    source.job_file = (folder_ / "job.textproto").string();
    source.materials_db = folder_ / "materials.db";
    return BuildBatch(source);
  }
  std::string RefusalOf(const std::string& table) const {
    const auto jobs = Build(table);
    return jobs ? "" : jobs.error().message;
  }

  fs::path folder_;
};

TEST_F(BatchJobsTest, AGlassMayHaveAnyOfItsNames) {
  WriteJob("machine_file: \"els-03\"");
  const auto jobs = Build("id,glass\na,K9\nb,BK7\nc,n-bk7\n");
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_EQ(jobs->at(0).by_cell.at("els-03").glass(), "H-K9L");
  EXPECT_EQ(jobs->at(1).by_cell.at("els-03").glass(), "N-BK7");
  EXPECT_EQ(jobs->at(2).by_cell.at("els-03").glass(), "N-BK7");
}

TEST_F(BatchJobsTest, AnUnknownGlassNamesItsLineAndWhatMayBeMeant) {
  WriteJob("machine_file: \"els-03\"");
  EXPECT_THAT(RefusalOf("id,glass\na,K9\nb,BK7X\n"),
              AllOf(HasSubstr("line 3 (b): glass: "), HasSubstr("BK7X"),
                    HasSubstr("did you mean N-BK7"), Not(HasSubstr("line 2"))));
}

constexpr const char* kCup =
    "machine_file: \"els-03\" glass: \"N-BK7\"\n"
    "models { text { text: \"{piece}\" font: \"DejaVu Serif\" } }\n";

TEST_F(BatchJobsTest, ACharacterThatNoFontHasIsNamedBeforeAnythingIsSubmitted) {
  WriteJob(kCup);
  const std::string table = "id,piece\na,Anna\nb,Zoë \U0001F984\nc,\u05D0\n";
  EXPECT_THAT(RefusalOf(table),
              AllOf(HasSubstr("line 3 (b): models[1].text.text: "), HasSubstr("U+1F984"),
                    HasSubstr("DejaVu Serif"), Not(HasSubstr("line 4"))))
      << "DejaVu Sans has the letter of line 4";
  WriteJob(std::string(kCup) +
           "models { text { text: \"{piece}\" font: \"DejaVu Serif\" "
           "fallback_fonts: \"none\" } }");
  EXPECT_THAT(RefusalOf(table),
              AllOf(HasSubstr("line 4 (c): models[2].text.text: "), HasSubstr("U+05D0")));
}

TEST_F(BatchJobsTest, ATextThatIsTooWideIsNamedOrShrunkAsItsRowAsks) {
  WriteJob(kCup);
  const std::string name = "Maximiliane-Josephine";
  EXPECT_THAT(
      RefusalOf("id,piece\na,Anna\nb," + name + "\n"),
      AllOf(HasSubstr("line 3 (b): models[1].text.text: \"" + name + "\" reaches"),
            HasSubstr("use height_mm ")));
  const auto shrunk =
      Build("id,piece,models[1].text.shrink_to_fit\na,Anna,true\nb," + name + ",true\n");
  ASSERT_TRUE(shrunk) << shrunk.error().message;
  EXPECT_THAT(shrunk->at(0).warnings, ::testing::IsEmpty());
  ASSERT_EQ(shrunk->at(1).warnings.size(), 1u);
  EXPECT_EQ(shrunk->at(1).warnings[0].code, WarningCode::kTextShrunk);
  EXPECT_THAT(
      shrunk->at(1).warnings[0].text,
      AllOf(HasSubstr("line 3 (b): models[1].text: "), HasSubstr("instead of 5 mm")));
}

TEST_F(BatchJobsTest, ANameThatIsNotFilledInIsNamed) {
  WriteJob(kCup);
  EXPECT_THAT(RefusalOf("id\na\n"), AllOf(HasSubstr("line 2 (a): models[1].text.text: "),
                                          HasSubstr("'piece'")));
}

TEST_F(BatchJobsTest, AMachineThatIsNotThereIsAnsweredWithTheSuppliedOnes) {
  WriteJob("machine_file: \"els-3\" glass: \"N-BK7\"");
  EXPECT_THAT(RefusalOf("id\na\n"),
              AllOf(HasSubstr("line 2 (a): machine_file: 'els-3' is neither"),
                    HasSubstr("did you mean els-03?"), HasSubstr("polar")));
}

}  // namespace
}  // namespace intaglio::cli
