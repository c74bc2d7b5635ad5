#include "services/console/submit/upload_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "services/console/submit/program_run.h"
#include "services/console/submit/submissions.h"
#include "services/console/submit/submit_api.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Uploads : public ::testing::Test {
 protected:
  /// Sends `bytes` from the offset on, of a file of `size` bytes.
  Result<UploadAnswer> Send(const std::string& bytes, std::uint64_t offset,
                            std::uint64_t size, const std::string& file = "knot.stl") {
    auto upload = uploads_.Open("order-7", file, offset, size);
    if (!upload) return tl::unexpected(upload.error());
    if (auto written = (*upload)->Write(bytes); !written)
      return tl::unexpected(written.error());
    return (*upload)->Close();
  }
  std::string Content(const std::string& file = "knot.stl") const {
    std::ifstream in(folder_ / "order-7" / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const fs::path folder_ = test::FreshFolder();
  UploadFolder uploads_{folder_};
};

TEST_F(Uploads, AFileIsThereWholeOrNotAtAllAndGoesOnWhereItEnded) {
  const auto part = Send("abcd", 0, 10);
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_FALSE(part->complete());
  EXPECT_FALSE(fs::exists(folder_ / "order-7/knot.stl"));
  EXPECT_EQ(uploads_.Find("order-7", "knot.stl")->received_bytes(), 4u);
  EXPECT_EQ(uploads_.Find("order-7", "knot.stl")->size_bytes(), 10u);
  const auto gap = Send("hij", 7, 10);
  ASSERT_FALSE(gap);
  EXPECT_EQ(gap.error().code, ErrorCode::kRefused);
  EXPECT_THAT(gap.error().message, HasSubstr("offset=4"));
  EXPECT_FALSE(Send("efghijkl", 4, 10)) << "more than was announced";
  const auto whole = Send("efghij", 4, 10);
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_TRUE(whole->complete());
  EXPECT_EQ(Content(), "abcdefghij");
  EXPECT_TRUE(uploads_.Find("order-7", "knot.stl")->complete());
}

TEST_F(Uploads, AWholeFileNeverChanges) {
  ASSERT_TRUE(Send("abcd", 0, 4));
  const auto again = Send("abcd", 0, 4);
  ASSERT_TRUE(again) << "the same bytes are fine: " << again.error().message;
  EXPECT_TRUE(again->complete());
  EXPECT_EQ(Send("abXd", 0, 4).error().code, ErrorCode::kRefused);
  EXPECT_EQ(Send("abcde", 0, 5).error().code, ErrorCode::kRefused);
  EXPECT_EQ(Content(), "abcd");
}

TEST_F(Uploads, OneConnectionSendsAFileAtATime) {
  auto first = uploads_.Open("order-7", "knot.stl", 0, 10);
  ASSERT_TRUE(first);
  EXPECT_EQ(uploads_.Open("order-7", "knot.stl", 0, 10).error().code,
            ErrorCode::kRefused);
  first->reset();
  EXPECT_TRUE(uploads_.Open("order-7", "knot.stl", 0, 10));
}

TEST_F(Uploads, NothingIsWrittenElsewhere) {
  for (const std::string name :
       {"", ".", "..", "../x", "a/b", ".job.json", "a\nb", "a\\b"})
    EXPECT_EQ(Send("x", 0, 1, name).error().code, ErrorCode::kInvalidValue) << name;
  EXPECT_EQ(Send("x", 0, 1, std::string(201, 'a')).error().code,
            ErrorCode::kInvalidValue);
  for (const std::string id : {"", "..", ".", "a/b", ".hidden"})
    EXPECT_FALSE(uploads_.Open(id, "a", 0, 1)) << id;
  EXPECT_EQ(Send("", 0, kMaxUploadBytes + 1).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(Send("x", 0, 1, "\xe7\x8e\xbb\xe7\x92\x83.svg")) << "any script";
  EXPECT_FALSE(UploadFolder("").Open("order-7", "a", 0, 1));
}

TEST_F(Uploads, ASubmissionHasAtMost64Files) {
  for (std::size_t i = 0; i < kMaxUploadsOfAJob; ++i)
    ASSERT_TRUE(Send("x", 0, 1, std::to_string(i)));
  EXPECT_EQ(Send("x", 0, 1, "another").error().code, ErrorCode::kTooLarge);
}

TEST_F(Uploads, AJobIsMadeOfFilesThatWereSentForIt) {
  ASSERT_TRUE(Send("solid", 0, 5));
  const auto check = [&](const std::string& model, const std::string& machine) {
    JobSpec job;
    job.add_models()->set_file(model);
    job.set_machine_file(machine);
    return CheckFilesOfSubmission(job, folder_ / "order-7",
                                  {{"keeps-none", ""}, {"own", "/shop/own.textproto"}});
  };
  EXPECT_TRUE(check("knot.stl", "els-03"));
  EXPECT_TRUE(check("knot.stl", ""));
  EXPECT_THAT(check("other.stl", "").error().message, HasSubstr("models[0].file"));
  EXPECT_FALSE(check("/etc/passwd", ""));
  EXPECT_FALSE(check("../order-8/knot.stl", ""));
  EXPECT_FALSE(check("knot.stl", "/etc/machine.textproto"));
  EXPECT_TRUE(check("knot.stl", "/shop/own.textproto")) << "of a machine of the shop";
  fs::create_symlink("/etc/passwd", folder_ / "order-7/link.stl");
  EXPECT_FALSE(check("link.stl", ""));
}

TEST(SubmissionPaths, AreAnIdOrAFileOfIt) {
  EXPECT_EQ(ParseSubmissionPath("/api/v1/submissions/a")->id, "a");
  EXPECT_EQ(ParseSubmissionPath("/api/v1/submissions/a")->file, "");
  EXPECT_EQ(ParseSubmissionPath("/api/v1/submissions/a/files/b.stl")->file, "b.stl");
  EXPECT_TRUE(ParseSubmissionPath("/api/v1/submissions/a/preview")->is_preview);
  EXPECT_FALSE(ParseSubmissionPath("/api/v1/submissions/a/file/b"));
  EXPECT_FALSE(ParseSubmissionPath("/api/v1/jobs"));
}

TEST(ProgramEnds, SeparateWhatIsForProgramsFromWhatIsForPeople) {
  const ProgramEnd end =
      EndOfProgram(2,
                   "{\"event\":\"submitted\"}\nintaglio: models: none\n"
                   "{\n \"a\": 1\n}\nand more\n");
  EXPECT_EQ(end.exit_code, 2);
  EXPECT_THAT(end.json, ElementsAre("{\"event\":\"submitted\"}\n", "{\n \"a\": 1\n}\n"));
  EXPECT_EQ(end.text, "models: none\nand more");
}

TEST(ProgramEnds, HaveTheReasonOfARefusalWithItsCode) {
  const auto refusal = [](const std::string& output) {
    return RefusalOf(EndOfProgram(2, output));
  };
  const ConsoleError answer = refusal(
      "points  [###--]  70 %\n{\n \"job\": 0,\n \"taken\": false,\n"
      " \"code\": \"not_found\",\n \"message\": \"glass: none\"\n}\n");
  EXPECT_EQ(answer.code(), "not_found");
  EXPECT_EQ(answer.message(), "glass: none");
  const ConsoleError event = refusal(
      "{\"time\":\"\",\"event\":\"refused\",\"job\":0,\"message\":\"models: none\","
      "\"code\":\"missing\"}\nintaglio: models: none\n");
  EXPECT_EQ(event.code(), "missing");
  EXPECT_EQ(event.message(), "models: none");
  const ConsoleError text = refusal("intaglio: models: none\n");
  EXPECT_EQ(text.code(), "invalid_value");
  EXPECT_EQ(text.message(), "models: none");
}

}  // namespace
}  // namespace intaglio::console
