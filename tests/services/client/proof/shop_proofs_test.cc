// When which folder of a shop is completed. The process that completes it is a script.

#include "services/client/proof/shop_proofs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <thread>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "services/client/proof/proof_folder.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ShopProofsTest : public ::testing::Test {
 protected:
  ShopProofsTest() {
    // What `intaglio verify FOLDER` leaves; the test removes it to have it fail.
    Script(
        "touch \"$2/report.json\" \"$2/views.png\" \"$2/customer.png\"; echo \"$@\" >> " +
        (folder_ / "calls").string());
  }

  void Script(const std::string& commands) {
    std::ofstream(folder_ / "intaglio") << "#!/bin/sh\n" << commands << "\n";
    fs::permissions(folder_ / "intaglio", fs::perms::owner_all);
  }
  JobView& Add(const std::string& uid, intaglio_JobState state) {
    JobView& job = jobs_[uid];
    job.uid = uid;
    job.number = static_cast<std::uint32_t>(jobs_.size());
    job.state = state;
    job.cell = "els-03";
    job.result_directory = (folder_ / uid).string();
    fs::create_directories(job.result_directory);
    std::ofstream(folder_ / uid / "path.ply") << "ply";
    std::ofstream(folder_ / uid / "journal.bin") << "journal";
    return job;
  }
  std::vector<std::string> Turn() {
    return proofs_.Turn(
        {jobs_,
         [this](const JobView&) {
           JobStages stages;
           if (outcome_known_)
             stages.mutable_engrave()->mutable_engrave()->set_made_count(7);
           return stages;
         },
         true},
        now_);
  }
  /// Turns until the processes that were started have ended. No time passes.
  std::vector<std::string> Settle() {
    std::vector<std::string> all = Turn();
    while (proofs_.at_work()) {
      std::this_thread::sleep_for(5ms);
      for (const std::string& sentence : Turn()) all.push_back(sentence);
    }
    return all;
  }
  bool IsDone(const std::string& uid) const {
    return fs::exists(folder_ / uid / kReportFile);
  }

  fs::path folder_ = test::FreshFolder();
  std::map<std::string, JobView> jobs_;
  bool outcome_known_ = true;
  ShopProofs::Clock::time_point now_{1h};
  ShopProofs proofs_{{folder_, "els-03", folder_ / "intaglio", {"--background", "dark"}}};
};

TEST_F(ShopProofsTest, AFolderIsCompletedWhenItsJobHasEnded) {
  JobView& job = Add("1-a", intaglio_JOB_ENGRAVING);
  EXPECT_THAT(Settle(), IsEmpty());
  EXPECT_FALSE(IsDone("1-a"));
  job.state = intaglio_JOB_DONE;
  EXPECT_THAT(Settle(), IsEmpty());
  EXPECT_TRUE(IsDone("1-a"));
  EXPECT_EQ(proofs_.pending_count(), 0u);
  std::ifstream calls(folder_ / "calls");
  std::string call;
  std::getline(calls, call);
  EXPECT_THAT(call,
              AllOf(HasSubstr("verify " + (folder_ / "1-a").string()),
                    HasSubstr("--glass " + folder_.string()),
                    HasSubstr("--customer-picture"), HasSubstr("--background dark")));
  std::ifstream in(folder_ / "1-a" / kStagesFile);
  const std::string stages((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THAT(stages, HasSubstr("\"made_count\": \"7\""));
}

TEST_F(ShopProofsTest, FoldersOfOthersAndWithoutAnEngravingAndCompleteOnesAreLeft) {
  Add("1-other", intaglio_JOB_DONE).cell = "els-04";
  Add("2-never", intaglio_JOB_CANCELLED);
  fs::remove(folder_ / "2-never" / "journal.bin");
  Add("3-complete", intaglio_JOB_DONE);
  for (const char* file : {kReportFile, kViewsFile, kCustomerFile}) {
    std::ofstream(folder_ / "3-complete" / file) << "there";
  }
  EXPECT_THAT(Settle(), IsEmpty());
  EXPECT_FALSE(fs::exists(folder_ / "calls"));
}

TEST_F(ShopProofsTest, JobsOfBeforeTheStartAreCompletedOneAfterTheOther) {
  Add("1-a", intaglio_JOB_DONE);
  Add("2-b", intaglio_JOB_FAILED);
  Add("3-c", intaglio_JOB_CANCELLED);
  Settle();
  for (const char* uid : {"1-a", "2-b", "3-c"}) EXPECT_TRUE(IsDone(uid)) << uid;
}

TEST_F(ShopProofsTest, TheOutcomeIsAwaitedForAWhile) {
  outcome_known_ = false;
  Add("1-a", intaglio_JOB_CANCELLED);
  Settle();
  now_ += ShopProofs::kOutcomeTime - 1ms;
  Settle();
  EXPECT_FALSE(IsDone("1-a"));
  now_ += 1ms;
  Settle();
  EXPECT_TRUE(IsDone("1-a"));
}

TEST_F(ShopProofsTest, WhatFailsIsReportedOnceAndTriedAgain) {
  const std::string works =
      "touch \"$2/report.json\" \"$2/views.png\" \"$2/customer.png\"";
  Script("echo a line; echo 'cannot write views.png: No space left on device'; exit 2");
  Add("1-a", intaglio_JOB_DONE);
  EXPECT_THAT(Settle(),
              ElementsAre(AllOf(HasSubstr("job 1"), HasSubstr("No space left on device"),
                                HasSubstr("intaglio verify"))));
  EXPECT_EQ(proofs_.pending_count(), 0u);
  now_ += ShopProofs::kFirstRetry - 1ms;
  EXPECT_THAT(Settle(), IsEmpty());
  now_ += 1ms;
  EXPECT_THAT(Settle(), IsEmpty()) << "the same again";
  Script(works);
  now_ += 2 * ShopProofs::kFirstRetry;
  EXPECT_THAT(Settle(), ElementsAre(HasSubstr("job 1: report and pictures are in")));
  EXPECT_TRUE(IsDone("1-a"));
}

TEST_F(ShopProofsTest, AProgramThatCannotBeStartedIsAnErrorLikeAnyOther) {
  fs::remove(folder_ / "intaglio");
  Add("1-a", intaglio_JOB_DONE);
  Turn();
  EXPECT_THAT(Turn(), ElementsAre(HasSubstr("does not exist")));
}

TEST_F(ShopProofsTest, GlassThatAnOpenJobNeedsIsKept) {
  const auto record = [&](const std::string& name, std::uint32_t power_up) {
    const auto bytes = formats::EncodeGlassHeader({Vec3(20, 20, 20), 1.5, 0.1, power_up});
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  };
  record("glass.rec", 3);
  record("glass-00000001.rec", 1);
  record("glass-00000002.rec", 2);
  Add("1-a", intaglio_JOB_PAUSED);
  std::ofstream journal(folder_ / "1-a" / "journal.bin", std::ios::binary);
  const auto put = [&](const auto& bytes) {
    journal.write(reinterpret_cast<const char*>(bytes.data()),
                  static_cast<std::streamsize>(bytes.size()));
  };
  put(formats::EncodeJournalHeader({4, 1}));
  formats::JournalRecord session;
  session.kind = formats::JournalKind::kSession;
  session.point = 2;
  put(formats::EncodeJournalRecord(session));
  put(formats::EncodeJournalRecord({}));
  journal.close();
  Settle();
  now_ += 1min;
  Settle();
  EXPECT_TRUE(fs::exists(folder_ / "glass.rec"));
  EXPECT_FALSE(fs::exists(folder_ / "glass-00000001.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "glass-00000002.rec"));
}

}  // namespace
}  // namespace intaglio::client
