#include "services/discretizer/model_intake.h"

#include <gtest/gtest.h>

#include <functional>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::discretizer {
namespace {

using bus::Borrow;
using test::Eventually;

class ModelIntakeTest : public testing::Test {
 protected:
  void Open(std::size_t model_count) {
    ASSERT_TRUE(intake.Open(job_uid, 1, part, model_count));
    ASSERT_TRUE(Eventually([&] { return writer.IsMatched(intake.reader().guid()); }));
    number = 0;
  }
  void Send(std::uint32_t model, std::uint64_t offset, std::uint64_t file_size,
            const std::vector<std::uint8_t>& bytes, bool last) {
    intaglio_ModelChunk chunk{};
    chunk.job_uid = Borrow(job_uid);
    chunk.attempt = 1;
    chunk.part = part.index;
    chunk.part_attempt = part.attempt;
    chunk.sequence_number = number++;
    chunk.model = model;
    chunk.offset = offset;
    chunk.file_size = file_size;
    chunk.last = last;
    Borrow(chunk.bytes, bytes);
    ASSERT_TRUE(writer.Write(chunk));
  }
  Result<bool> PollUntilDecided() {
    Result<bool> taken = false;
    EXPECT_TRUE(Eventually([&] { return taken = intake.Poll(), !taken || *taken; }));
    return taken;
  }
  void ExpectRefused(ErrorCode code) {
    const auto taken = PollUntilDecided();
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().code, code) << taken.error().message;
  }

  const std::string job_uid = "j";
  host::TaskPart part{3, 8, 1};
  bus::Bus bus{test::PrivateBusOptions()};
  bus::Writer<intaglio_ModelChunk> writer{bus, bus::kModelChunk};
  ModelIntake intake{bus, "discretizer", {}};
  std::uint64_t number = 0;
};

TEST_F(ModelIntakeTest, PutsTheChunksOfSeveralFilesTogether) {
  Open(3);
  Send(0, 0, 3, {1, 2}, false);
  Send(0, 2, 3, {3}, false);
  Send(1, 0, 0, {}, false);  // an empty file is the importer's to refuse
  Send(2, 0, 1, {4}, true);
  ASSERT_TRUE(PollUntilDecided());
  const auto files = intake.TakeFiles();
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[0], (FileBytes{std::byte{1}, std::byte{2}, std::byte{3}}));
  EXPECT_TRUE(files[1].empty());
  EXPECT_EQ(files[2], FileBytes{std::byte{4}});
}

TEST_F(ModelIntakeTest, RefusesWhatDoesNotFit) {
  const std::function<void()> cases[] = {
      [&] { Send(1, 0, 1, {1}, false); },  // first model missing
      [&] { Send(0, 1, 2, {1}, false); },  // starts in the middle
      [&] {
        Send(0, 0, 1, {1, 2}, false);
      },  // beyond its size
      [&] {
        Send(0, 0, 4, {1, 2}, true);
      },                                  // ends too early
      [&] { Send(0, 0, 1, {1}, true); },  // second model missing
      [&] { Send(0, 0, 4, {1}, false), Send(0, 2, 4, {1}, false); },  // a hole
      [&] { Send(0, 0, 4, {1}, false), Send(0, 1, 5, {1}, false); },  // grows
      [&] {
        Send(0, 0, 4, {1}, false), Send(1, 0, 1, {1}, false);
      },  // next one too early
  };
  for (const auto& send : cases) {
    Open(2);
    send();
    ExpectRefused(ErrorCode::kFault);
  }
}

TEST_F(ModelIntakeTest, NoticesAMissingChunk) {
  Open(1);
  number = 1;
  Send(0, 0, 1, {1}, true);
  ExpectRefused(ErrorCode::kLinkLost);
}

TEST_F(ModelIntakeTest, RefusesTooMuchBeforeItTakesTheMemory) {
  Open(1);
  Send(0, 0, 1ull << 50, {1}, false);
  ExpectRefused(ErrorCode::kTooLarge);
  Open(2);
  Send(0, 0, 1, {1}, false);
  Send(1, 0, ReadLimits().max_file_bytes, {1}, false);
  ExpectRefused(ErrorCode::kTooLarge);
}

TEST_F(ModelIntakeTest, RefusesWhatExceedsTheCredit) {
  Open(1);
  // More than a window in one turn.
  for (std::uint64_t i = 0; i < 65; ++i) Send(0, i, 1000, {1}, false);
  ASSERT_TRUE(writer.WaitForAcknowledgements(std::chrono::seconds(5)));
  ExpectRefused(ErrorCode::kFault);
}

TEST_F(ModelIntakeTest, DropsWhatIsSentToOthers) {
  Open(1);
  for (const host::TaskPart others : {host::TaskPart{2, 8, 1}, host::TaskPart{3, 8, 0}}) {
    part = others;
    Send(0, 0, 1, {7}, true);
  }
  part = {3, 8, 1};
  number = 0;
  Send(0, 0, 1, {1}, true);
  ASSERT_TRUE(PollUntilDecided());
  EXPECT_EQ(intake.TakeFiles().at(0), FileBytes{std::byte{1}});
}

TEST_F(ModelIntakeTest, AJobWhosePointsAreItsOwnNeedsNoFile) {
  ASSERT_TRUE(intake.Open(job_uid, 1, part, 0));
  const auto taken = intake.Poll();
  ASSERT_TRUE(taken);
  EXPECT_TRUE(*taken);
  EXPECT_TRUE(intake.TakeFiles().empty());
}

}  // namespace
}  // namespace intaglio::discretizer
