// Many clients at once: every one of them gets a true answer, and the queue has what they
// were answered. INTAGLIO_CLIENTS=200 takes as many as a script of a large shop starts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <regex>
#include <set>

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

class ManyClients : public ::testing::Test {
 protected:
  ManyClients() {
    setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
    const char* count = std::getenv("INTAGLIO_CLIENTS");
    if (count != nullptr) count_ = std::stoul(count);
  }
  std::vector<std::string> InShop(std::vector<std::string> words) const {
    for (const std::string& word :
         {std::string("--domain"), std::string("45"), std::string("--tag"),
          "many" + std::to_string(getpid())}) {
      words.push_back(word);
    }
    return words;
  }
  std::unique_ptr<Running> Start(const std::vector<std::string>& words,
                                 const std::string& name) const {
    return std::make_unique<Running>(Program("intaglio"), InShop(words),
                                     folder_ / (name + ".txt"));
  }
  /// Starts all clients at once, each with its id; every fifth gives a job that is
  /// refused.
  std::vector<Ended> SubmitAll(const std::string& run) const {
    std::vector<std::unique_ptr<Running>> clients;
    for (std::size_t i = 0; i < count_; ++i) {
      std::vector<std::string> words = {"submit", "sample", "--id",
                                        "client-" + std::to_string(i)};
      if (IsRefused(i)) words.insert(words.end(), {"--glass", "unobtainium"});
      clients.push_back(Start(words, run + std::to_string(i)));
    }
    std::vector<Ended> ends;
    for (const auto& client : clients) ends.push_back(client->WaitForEnd(150s));
    return ends;
  }
  static bool IsRefused(std::size_t client) { return client % 5 == 4; }

  /// The number of the job that a client was answered; "": none.
  static std::string NumberIn(const Ended& ended) {
    std::smatch found;
    return std::regex_search(ended.output, found, std::regex("job (\\d+) \\("))
               ? found[1].str()
               : "";
  }

  const fs::path folder_ = test::FreshFolder();
  std::size_t count_ = 50;
};

TEST_F(ManyClients, AreAnsweredTrulyEachAndMayTryAgain) {
  const auto up = Start({"up", "--folder", (folder_ / "shop").string()}, "up");
  ASSERT_TRUE(testing::Eventually(
      [&] { return up->Output().find("the shop is open") != std::string::npos; }, 60s))
      << up->Output();
  // For 200 of them, on two cores that others leave alone.
  const test::Patience minute(60s);
  const auto began = std::chrono::steady_clock::now();
  const std::vector<Ended> ends = SubmitAll("first");
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  std::cerr << count_ << " clients were answered within " << took.count() << " s\n";
  EXPECT_FALSE(minute.over()) << took.count() << " s";

  std::vector<std::string> numbers;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    ASSERT_TRUE(ends[i].in_time) << i << ": " << ends[i].output;
    numbers.push_back(NumberIn(ends[i]));
    EXPECT_EQ(ends[i].exit_code, IsRefused(i) ? 2 : 0) << i << ": " << ends[i].output;
    EXPECT_EQ(numbers.back().empty(), IsRefused(i)) << i << ": " << ends[i].output;
    if (IsRefused(i)) {
      EXPECT_THAT(ends[i].output, HasSubstr("unobtainium"));
    }
  }
  // The same commands with the same ids: the same answers, and nothing more in the queue.
  const std::vector<Ended> again = SubmitAll("again");
  std::set<std::string> answered;
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(NumberIn(again[i]), numbers[i]) << i << ": " << again[i].output;
    EXPECT_EQ(again[i].exit_code, ends[i].exit_code) << i << ": " << again[i].output;
    if (!numbers[i].empty()) answered.insert(numbers[i]);
  }
  const Ended list = Start({"list", "--json"}, "list")->WaitForEnd(60s);
  EXPECT_EQ(list.exit_code, 0) << list.output;
  std::set<std::string> listed;
  const std::regex job("\"job\": ?\"?(\\d+)");
  for (std::sregex_iterator at(list.output.begin(), list.output.end(), job), end;
       at != end; ++at) {
    listed.insert((*at)[1].str());
  }
  EXPECT_EQ(listed, answered) << list.output;
}

}  // namespace
}  // namespace intaglio
