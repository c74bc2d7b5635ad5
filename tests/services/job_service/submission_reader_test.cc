#include "services/job_service/submission_reader.h"

#include <gmock/gmock.h>

#include <future>
#include <thread>

#include "tests/patience.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// A disk that answers when it is let go. Jobs that begin with 'h' lie on it.
struct HangingDisk {
  std::promise<void> answers;
  std::shared_future<void> answered{answers.get_future()};
};

class SubmissionReaderTest : public testing::Test {
 protected:
  void TearDown() override { disk_->answers.set_value(); }
  void Add(const std::string& uid, const std::string& job) {
    reader_.Add({uid, "ann@shop", {job.begin(), job.end()}}, now_);
  }
  /// What it answers by this time; waits for so many that do not hang.
  std::vector<SubmissionReader::Answer> Answers(std::size_t count) {
    std::vector<SubmissionReader::Answer> all;
    for (const test::Patience patience(10s); all.size() < count && !patience.over();
         std::this_thread::sleep_for(1ms)) {
      for (auto& answer : reader_.Take(now_)) all.push_back(std::move(answer));
    }
    return all;
  }
  /// Refused by the time; none is waited for.
  std::string HangsAndIsRefused(const std::string& uid) {
    Add(uid, "hangs");
    if (const auto at_once = reader_.Take(now_); !at_once.empty()) {
      return at_once.at(0).frozen.error().message;
    }
    now_ += SubmissionReader::kReadWithin;
    const auto answers = reader_.Take(now_);
    EXPECT_EQ(answers.size(), 1u);
    EXPECT_EQ(answers.at(0).uid, uid);
    EXPECT_EQ(answers.at(0).frozen.error().code, ErrorCode::kTimedOut);
    return answers.at(0).frozen.error().message;
  }

  std::shared_ptr<HangingDisk> disk_ = std::make_shared<HangingDisk>();
  std::chrono::nanoseconds now_{100s};
  SubmissionReader reader_{
      [disk = disk_](const std::vector<std::uint8_t>& job) -> Result<FrozenJob> {
        if (!job.empty() && job[0] == 'h') disk->answered.wait();
        if (job.empty()) return Fail(ErrorCode::kMissing, "the job is empty");
        if (job[0] == 't') throw std::runtime_error("no memory");
        FrozenJob frozen;
        frozen.mutable_job()->set_name(std::string(job.begin(), job.end()));
        return frozen;
      }};
};

TEST_F(SubmissionReaderTest, AnswersInTheOrderOfSubmission) {
  for (int i = 0; i < 20; ++i) Add("s" + std::to_string(i), std::to_string(i));
  Add("wrong", "");
  const auto answers = Answers(21);
  ASSERT_EQ(answers.size(), 21u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(answers[i].uid, "s" + std::to_string(i));
    EXPECT_EQ(answers[i].client, "ann@shop");
    EXPECT_EQ(answers[i].frozen->job().name(), std::to_string(i));
  }
  EXPECT_EQ(answers[20].frozen.error().message, "the job is empty");
}

TEST_F(SubmissionReaderTest, AnExceptionIsARefusal) {
  Add("throws", "throws");
  Add("next", "read");
  const auto answers = Answers(2);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].frozen.error().code, ErrorCode::kFault);
  EXPECT_THAT(answers[0].frozen.error().message, HasSubstr("no memory"));
  EXPECT_TRUE(answers[1].frozen);
}

TEST_F(SubmissionReaderTest, ARepeatWhileItIsReadIsIgnored) {
  Add("one", "hangs");
  Add("one", "hangs");
  now_ += SubmissionReader::kReadWithin;
  EXPECT_EQ(reader_.Take(now_).size(), 1u);
  EXPECT_EQ(reader_.Take(now_ + 1h).size(), 0u);
}

TEST_F(SubmissionReaderTest, ADiskThatHangsHoldsNobodyUp) {
  Add("first", "hangs");
  Add("second", "read");
  EXPECT_TRUE(reader_.Take(now_).empty());
  now_ += SubmissionReader::kReadWithin - 1ns;
  EXPECT_TRUE(reader_.Take(now_).empty());
  now_ += 1ns;
  const auto answers = Answers(2);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_THAT(answers[0].frozen.error().message, HasSubstr("within 5 s"));
  EXPECT_THAT(answers[0].frozen.error().message, HasSubstr("machine_file"));
  EXPECT_EQ(answers[1].uid, "second");
  EXPECT_TRUE(answers[1].frozen);
}

TEST_F(SubmissionReaderTest, NoMoreThanSomeThreadsHang) {
  for (std::size_t i = 0; i < SubmissionReader::kMaxHanging; ++i) {
    EXPECT_THAT(HangsAndIsRefused(std::to_string(i)), HasSubstr("within 5 s"));
  }
  EXPECT_THAT(HangsAndIsRefused("more"), HasSubstr("files of 4 earlier submissions"));
  // When the mount is back all goes on.
  disk_->answers.set_value();
  disk_->answers = {};
  bool read = false;
  for (int i = 0; i < 10'000 && !read; ++i) {
    Add("again" + std::to_string(i), "read");
    const auto answers = Answers(1);
    read = answers.size() == 1 && answers[0].frozen;
  }
  EXPECT_TRUE(read);
}

TEST_F(SubmissionReaderTest, OneProcessThatFloodsDelaysItselfAlone) {
  const auto add = [&](const std::string& uid, const std::string& process) {
    return reader_.Add({uid, "ann@shop", {'r'}, process}, now_);
  };
  std::size_t waiting = 0;
  for (int i = 0; i < 5000; ++i)
    waiting += add("flood " + std::to_string(i), "flooder") ? 1 : 0;
  // The first one is being read.
  EXPECT_EQ(waiting, SubmissionReader::kMaxOfProcess + 1);
  EXPECT_TRUE(add("flood 1", "flooder")) << "it waits already";
  EXPECT_TRUE(add("one", "ann"));
  EXPECT_TRUE(add("two", "ann"));
  EXPECT_TRUE(add("three", "bob"));
  std::vector<std::string> order;
  for (const auto& answer : Answers(6)) order.push_back(answer.uid);
  order.resize(6);
  EXPECT_THAT(order, testing::ElementsAre("flood 0", "one", "three", "flood 1", "two",
                                          "flood 2"));
}

}  // namespace
}  // namespace intaglio::job_service
