#include "services/job/files/job_file.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <filesystem>
#include <fstream>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/placeholders.h"
#include "services/job/files/series.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using google::protobuf::util::MessageDifferencer;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class JobFileTest : public testing::Test {
 protected:
  JobFileTest() : folder_(test::FreshFolder()) {}
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  Error ErrorOf(const std::string& name, const std::string& text) const {
    const auto job = ReadJobFile(Write(name, text));
    return job ? Error{ErrorCode::kInvalidValue, "no error", ""} : job.error();
  }

  fs::path folder_;
};

/// The job, or one for each row of the supplied table when it has names to fill in.
std::vector<JobSpec> PiecesOf(const JobSpec& job) {
  if (PlaceholdersOf(job.name()).empty()) return {job};
  const fs::path folder = INTAGLIO_SOURCE_DIR "/deploy/jobs";
  return MakeSeries(job, io::ReadCsv(folder / "names.csv").value(), folder).value();
}

TEST_F(JobFileTest, ShippedExamplesAreRight) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(INTAGLIO_SOURCE_DIR "/deploy/jobs")) {
    const fs::path ending = entry.path().extension();
    if (ending != ".textproto" && ending != ".json") continue;
    const auto job = ReadJobFile(entry.path());
    ASSERT_TRUE(job) << job.error().message;
    const auto machine = ReadMachineFile(job->machine_file());
    ASSERT_TRUE(machine) << machine.error().message;
    for (const JobSpec& piece : PiecesOf(*job)) {
      EXPECT_THAT(CheckAll(piece, *machine, 0.65), IsEmpty()) << entry.path();
    }
    ++count;
  }
  EXPECT_GE(count, 5);
}

// Editors of Windows write it before a text; another one is that of UTF-16.
TEST_F(JobFileTest, AByteOrderMarkIsNoPartOfTheJob) {
  const std::string mark = "\xEF\xBB\xBF";
  const auto text = ReadJobFile(Write("a.textproto", mark + "name: \"Ä\"\r\n"));
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(text->name(), "Ä");
  const auto json = ReadJobFile(Write("a.json", mark + "{\"name\": \"Ä\"}"));
  ASSERT_TRUE(json) << json.error().message;
  EXPECT_EQ(json->name(), "Ä");
  EXPECT_THAT(ErrorOf("b.textproto", mark + "glas: \"K9\"").message,
              HasSubstr("b.textproto:1:5: "))
      << "columns are those of the text";
  const std::string wide("\xFF\xFEn\0a\0m\0e\0", 10);
  for (const char* name : {"c.textproto", "c.json"})
    EXPECT_THAT(
        ErrorOf(name, wide).message,
        testing::EndsWith(std::string(name) + ": is in UTF-16; save it as UTF-8"));
}

TEST_F(JobFileTest, TextAndJsonRoundTrip) {
  const JobSpec job = WithDefaults(GoodJob(), GoodMachine());
  std::string text, json;
  ASSERT_TRUE(google::protobuf::TextFormat::PrintToString(job, &text));
  google::protobuf::util::JsonPrintOptions with_names;
  with_names.preserve_proto_field_names = true;
  ASSERT_TRUE(google::protobuf::util::MessageToJsonString(job, &json, with_names).ok());
  for (const char* name : {"job.textproto", "job.txtpb", "job.json"}) {
    const auto again =
        ReadJobFile(Write(name, fs::path(name).extension() == ".json" ? json : text));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_TRUE(MessageDifferencer::Equals(job, *again)) << name;
  }
}

TEST_F(JobFileTest, MachineRoundTrip) {
  for (const char* name : {"machine.textproto", "machine.json"}) {
    ASSERT_TRUE(WriteMachineFile(folder_ / name, GoodMachine()));
    const auto again = ReadMachineFile(folder_ / name);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_TRUE(MessageDifferencer::Equals(GoodMachine(), *again)) << name;
  }
}

TEST_F(JobFileTest, PathsAreRelativeToTheJobFile) {
  const auto job = ReadJobFile(Write(
      "a.textproto", R"(models { file: "m/a.stl" } models { file: "/b.stl" } models {}
                              machine_file: "../x.textproto")"));
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_EQ(job->models(0).file(), (folder_ / "m/a.stl").string());
  EXPECT_EQ(job->models(1).file(), "/b.stl");
  EXPECT_EQ(job->models(2).file(), "");
  EXPECT_EQ(job->machine_file(), (folder_.parent_path() / "x.textproto").string());
}

TEST_F(JobFileTest, TextErrorsNameLineAndColumn) {
  const Error unknown =
      ErrorOf("a.textproto", "name: \"a\"\nblock {\n  marginmm: 3\n}\n");
  EXPECT_EQ(unknown.code, ErrorCode::kUnreadable);
  EXPECT_THAT(unknown.message,
              StartsWith((folder_ / "a.textproto").string() + ":3:11: "));
  EXPECT_THAT(unknown.message, HasSubstr("marginmm"));
  EXPECT_THAT(ErrorOf("b.textproto", "name: \"a\"\nseed: -1\n").message,
              HasSubstr("b.textproto:2:7: "));
  EXPECT_THAT(ErrorOf("c.textproto", "name: \"a\" name: \"b\"").message,
              HasSubstr(":1:"));
}

TEST_F(JobFileTest, JsonErrorsNameLineAndColumn) {
  EXPECT_THAT(ErrorOf("a.json", "{\"block\":\n  {\"size_mm\" 3}}").message,
              HasSubstr("a.json:2:14: Expected : between key:value pair."));
  EXPECT_THAT(
      ErrorOf("b.json", "{\"name\": \"{[\\\"\",\n \"block\": {\n  \"sizemm2\": 3}}")
          .message,
      HasSubstr("b.json:3:3: (block) sizemm2: Cannot find field."));
  EXPECT_THAT(ErrorOf("c.json",
                      "{\"models\": [{\"file\": \"a, b\"},\n"
                      " {\"file\": \"a\", \"placement\": {\"unit_mm\": \"x\"}}]}")
                  .message,
              HasSubstr("c.json:2:30: (models[1].placement.unit_mm)"));
  EXPECT_THAT(ErrorOf("d.json", "{\n\"colour\": 1}").message, HasSubstr("d.json:2:1: "));
  EXPECT_THAT(ErrorOf("e.json", "[]").message, HasSubstr("e.json: "));
}

TEST_F(JobFileTest, AMistypedFieldIsAnsweredWithTheNearestOfItsMessage) {
  EXPECT_THAT(ErrorOf("a.textproto", "glas: \"N-BK7\"").message,
              HasSubstr("Did you mean glass?"));
  EXPECT_THAT(ErrorOf("b.textproto", "block {\n  marginmm: 3\n}\n").message,
              HasSubstr("Did you mean margin_mm?"));
  EXPECT_THAT(ErrorOf("c.json", "{\"glas\": \"N-BK7\"}").message,
              HasSubstr("Did you mean glass?"));
  EXPECT_THAT(
      ErrorOf("d.json", "{\"models\": [{\"placement\": {\"fit_hight_mm\": 3}}]}").message,
      HasSubstr("Did you mean fit_height_mm?"));
  EXPECT_THAT(ErrorOf("e.textproto", "colour: 1").message,
              ::testing::Not(HasSubstr("Did you mean")));
}

TEST_F(JobFileTest, WhatIsNoJobFileIsRefused) {
  EXPECT_EQ(ErrorOf("a.yaml", "").code, ErrorCode::kUnsupported);
  EXPECT_EQ(ErrorOf("a.textproto", std::string(kMaxJobFileBytes + 1, '#')).code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(ReadJobFile(folder_ / "absent.json").error().code, ErrorCode::kNotFound);
  fs::create_directory(folder_ / "folder.json");
  EXPECT_EQ(ReadJobFile(folder_ / "folder.json").error().code, ErrorCode::kIo);
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "[";
  EXPECT_EQ(ErrorOf("deep.json", "{\"models\": " + deep).code, ErrorCode::kUnreadable);
}

TEST_F(JobFileTest, MachineFilesAreCheckedAndCompleted) {
  MachineSpec machine = GoodMachine();
  machine.clear_stage_lag_s();
  machine.mutable_laser_line()->clear_baud();
  ASSERT_TRUE(WriteMachineFile(folder_ / "a.textproto", machine));
  const auto read = ReadMachineFile(folder_ / "a.textproto");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->stage_lag_s(), 0.0002);
  EXPECT_EQ(read->laser_line().baud(), 115200u);
  machine.mutable_second_order()->set_natural_frequency_hz(120);
  machine.mutable_second_order()->set_damping_ratio(0.7);
  ASSERT_TRUE(WriteMachineFile(folder_ / "second.textproto", machine));
  const auto second = ReadMachineFile(folder_ / "second.textproto");
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->has_stage_lag_s()) << "it has its drive";
  machine.clear_drive();
  machine.clear_name();
  machine.clear_lenses();
  ASSERT_TRUE(WriteMachineFile(folder_ / "b.textproto", machine));
  const auto bad = ReadMachineFile(folder_ / "b.textproto");
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, HasSubstr("\nname: is missing"));
  EXPECT_THAT(bad.error().message, HasSubstr("\nlenses: is missing"));
}

// What every default is; a change of one shows here.
TEST_F(JobFileTest, DefaultsAreAsDocumented) {
  JobSpec job = WithDefaults(GoodJob(), GoodMachine());
  job.mutable_models(0)->set_file("sample.obj");
  job.set_machine_file("els-03.textproto");
  std::string text;
  google::protobuf::TextFormat::PrintToString(job, &text);
  std::ifstream golden(INTAGLIO_SOURCE_DIR
                       "/tests/services/job/golden/defaults.textproto");
  const std::string expected{std::istreambuf_iterator<char>(golden), {}};
  EXPECT_EQ(text, expected);
}

TEST_F(JobFileTest, DefaultsOfTheOtherMethods) {
  JobSpec job;
  job.mutable_discretization()->set_min_spacing_mm(0.2);
  job.mutable_discretization()->mutable_fill();
  job.mutable_ordering()->mutable_layers();
  job = WithDefaults(job, GoodMachine());
  EXPECT_EQ(job.discretization().fill().vertex_distance_mm(), 0.2);
  EXPECT_TRUE(job.discretization().fill().full_fill());
  EXPECT_EQ(job.ordering().layers().layer_thickness_mm(), 0.2);
  job.mutable_discretization()->mutable_rays();
  job = WithDefaults(job, GoodMachine());
  EXPECT_EQ(job.discretization().rays().distance_mm(), 0.2);
}

}  // namespace
}  // namespace intaglio
