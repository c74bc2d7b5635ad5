#include "services/cli/batch/batch_continue.h"

#include <gmock/gmock.h>

#include <fstream>

#include "services/job/files/json_text.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using ::testing::ElementsAre;

BatchJob Job(const std::string& id, std::vector<std::size_t> after = {}) {
  BatchJob job;
  job.id = id;
  job.planned.after = std::move(after);
  return job;
}

void Add(BatchResults& results, const std::string& id, const std::string& state,
         const std::string& verdict) {
  BatchJobResult& result = *results.add_jobs();
  result.set_id(id);
  result.set_state(state);
  result.set_verdict(verdict);
  result.set_key("key-" + id);
}

class BatchContinue : public testing::Test {
 protected:
  BatchContinue() {
    Add(earlier_, "made", "done", "good");
    Add(earlier_, "odd", "done", "good_with_warnings");
    Add(earlier_, "spoiled", "done", "not_good");
    Add(earlier_, "cut", "cancelled", "none");
    Add(earlier_, "left", "engraving", "none");
  }
  const std::vector<BatchJob> all_ = {Job("made"),         Job("odd", {0}),
                                      Job("spoiled", {0}), Job("cut", {1, 2}),
                                      Job("left"),         Job("new", {4})};
  BatchResults earlier_;
};

TEST_F(BatchContinue, LeavesOutWhatIsGood) {
  const auto left = LeaveOutDone(all_, earlier_);
  std::vector<std::string> ids, keys;
  for (const BatchJob& job : left) {
    ids.push_back(job.id);
    keys.push_back(job.key);
  }
  EXPECT_THAT(ids, ElementsAre("spoiled", "cut", "left", "new"));
  EXPECT_THAT(keys, ElementsAre("", "", "key-left", ""))
      << "what had not ended is followed, the others are made anew";
  EXPECT_THAT(left[0].planned.after, ElementsAre());
  EXPECT_THAT(left[1].planned.after, ElementsAre(0));
  EXPECT_THAT(left[3].planned.after, ElementsAre(2));
}

TEST_F(BatchContinue, TheResultsAreThoseOfTheWholeBatch) {
  BatchResults now;
  for (const char* id : {"spoiled", "cut", "left", "new"}) Add(now, id, "done", "good");
  now.set_good(4);
  const BatchResults joined = JoinResults(all_, earlier_, now);
  std::vector<std::string> ids;
  for (const BatchJobResult& result : joined.jobs()) ids.push_back(result.id());
  EXPECT_THAT(ids, ElementsAre("made", "odd", "spoiled", "cut", "left", "new"));
  EXPECT_EQ(joined.good(), 5u);
  EXPECT_EQ(joined.good_with_warnings(), 1u);
}

TEST_F(BatchContinue, ReadsWhatResultsHasWritten) {
  const auto file = test::FreshFolder() / "made.json";
  std::ofstream(file) << JsonTextOf(earlier_).value();
  const auto read = ReadBatchResults(file);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->jobs_size(), 5);
  std::ofstream(file) << "id,name";
  EXPECT_EQ(ReadBatchResults(file).error().code, ErrorCode::kUnreadable);
}

}  // namespace
}  // namespace intaglio::cli
