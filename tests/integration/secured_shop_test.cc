// Real programs with identities: a whole job, an observer who may read but not write, and
// the error messages for a program without an identity or with a wrong one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <regex>

#include "services/platform/bus/identity.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

constexpr char kSample[] = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto";

class SecuredShop : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!bus::SecurityConfiguration({folder_, {}, {}})) {
      GTEST_SKIP()
          << "the DDS library has no security plugins: install Cyclone DDS built "
             "with ENABLE_SECURITY";
    }
    setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
    unsetenv("INTAGLIO_SECURITY");
    const Ended made = Type({"security", "new", keys_.string(), "--domain", "46"});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }

  Ended Type(const std::vector<std::string>& words,
             const std::string& program = "intaglio") {
    Running run(Program(program), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    const Ended ended = run.WaitForEnd(120s);
    std::cout << "  " << program;
    for (const std::string& word : words) std::cout << " " << word;
    std::cout << "\n    -> " << ended.exit_code << ": " << ended.output.substr(0, 400)
              << "\n";
    return ended;
  }
  std::vector<std::string> As(const std::string& identity,
                              std::vector<std::string> words) const {
    words.insert(words.end(),
                 {"--domain", "46", "--tag", "secured" + std::to_string(getpid()),
                  "--security", identity});
    return words;
  }

  fs::path folder_ = test::FreshFolder();
  fs::path keys_ = folder_ / "keys";
  int typed_ = 0;
};

TEST_F(SecuredShop, EngravesAWholeJob) {
  const Ended ended =
      Type(As(keys_.string(), {"run", kSample, "--height", "5", "--lockstep", "--out",
                               (folder_ / "out").string()}));
  EXPECT_TRUE(ended.in_time);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_TRUE(fs::exists(folder_ / "out" / "report.json"));
}

// The recorder's identity writes nothing but its health, and receives everything.
TEST_F(SecuredShop, RecordsEverythingAndReplaysAsWhoMayWriteIt) {
  const std::string session = (folder_ / "out" / "session.mcap").string();
  ASSERT_EQ(Type(As(keys_.string(), {"run", kSample, "--height", "5", "--lockstep",
                                     "--out", (folder_ / "out").string()}))
                .exit_code,
            0);
  const Ended list = Type({"recording", "list", session});
  for (const char* topic :
       {"JobSubmission", "JobStatus", "EngraveTask", "TaskStatus", "Permission",
        "MotionSegmentBatch", "PulseEventBatch", "ModelChunk", "PointBatch", "PathBatch"})
    EXPECT_THAT(list.output, HasSubstr(topic));
  EXPECT_THAT(Type({"recording", "info", session}).output,
              ::testing::Not(HasSubstr("missing")));
  for (const char* service : {"discretizer", "sorter", "synchronizer"})
    EXPECT_EQ(Type({"replay", session, "--against", service}).exit_code, 0) << service;
  const std::vector<std::string> play = {"replay", session, "--fast", "--topic",
                                         "LampSync"};
  EXPECT_EQ(Type(As((keys_ / "cell-els-03").string(), play)).exit_code, 0);
  for (const char* reader : {"observer", "recorder"}) {
    const Ended refused = Type(As((keys_ / reader).string(), play));
    EXPECT_NE(refused.exit_code, 0) << reader;
    EXPECT_THAT(refused.output, HasSubstr("permissions do not allow"));
  }
}

/// Two hosts of their own on this one, and a cable between them; gone with the test.
class TwoHosts {
 public:
  TwoHosts() {
    made_ = Do("ip netns add " + Host("a")) && Do("ip netns add " + Host("b")) &&
            Do("ip link add " + Link("a") + " netns " + Host("a") +
               " type veth peer name " + Link("b") + " netns " + Host("b")) &&
            Raise("a", "10.77.0.1") && Raise("b", "10.77.0.2");
  }
  ~TwoHosts() {
    Do("ip netns delete " + Host("a"));
    Do("ip netns delete " + Host("b"));
  }
  bool made() const { return made_; }
  std::string Host(const std::string& side) const { return name_ + side; }
  std::string Link(const std::string& side) const { return "v" + name_ + side; }

 private:
  static bool Do(const std::string& command) {
    return std::system((command + " 2>/dev/null").c_str()) == 0;
  }
  bool Raise(const std::string& side, const std::string& address) const {
    const std::string at = "ip -n " + Host(side) + " ";
    return Do(at + "address add " + address + "/24 dev " + Link(side)) &&
           Do(at + "link set lo up") && Do(at + "link set " + Link(side) + " up");
  }
  std::string name_ = "t" + std::to_string(getpid());
  bool made_ = false;
};

// As docs/services.md describes it: the other host has no key but that of its role.
TEST_F(SecuredShop, SpansTwoHosts) {
  const TwoHosts hosts;
  if (!hosts.made()) GTEST_SKIP() << "network namespaces need root";
  setenv("INTAGLIO_ALLOW_ROOT", "1", 1);
  const fs::path worker = folder_ / "stage-worker";
  fs::copy(keys_ / "stage-worker", worker);
  std::vector<std::string> there =
      As(worker, {"netns", "exec", hosts.Host("b"), Program("intaglio-discretizer"),
                  "--interface", hosts.Link("b")});
  Running discretizer("/usr/sbin/ip", there, folder_ / "discretizer.txt");
  std::vector<std::string> here =
      As(keys_, {"netns", "exec", hosts.Host("a"), Program("intaglio"), "run", kSample,
                 "--height", "5", "--lockstep", "--without", "discretizer", "--interface",
                 hosts.Link("a"), "--out", (folder_ / "out").string()});
  Running run("/usr/sbin/ip", here, folder_ / "run.txt");
  const Ended ended = run.WaitForEnd(120s);
  unsetenv("INTAGLIO_ALLOW_ROOT");
  std::cout << "  " << discretizer.Output() << "\n";
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(discretizer.Output().find("done, "), std::string::npos);
}

// In real time, with commands from other processes: each with the identity of its role.
TEST_F(SecuredShop, LetsTheObserverReadAndTheOperatorCommand) {
  Running up(Program("intaglio"),
             As(keys_.string(), {"up", "--folder", (folder_ / "shop").string(), "--block",
                                 "50", "50", "30"}),
             folder_ / "up.txt");
  ASSERT_TRUE(Eventually(
      [&] { return up.Output().find("the shop is open") != std::string::npos; }, 90s))
      << up.Output();
  const std::string observer = keys_ / "observer", operator_keys = keys_ / "operator";
  const Ended submitted = Type(As(operator_keys, {"submit", kSample, "--height", "5"}));
  EXPECT_EQ(submitted.exit_code, 0);
  const Ended seen = Type(As(observer, {"list"}));
  EXPECT_EQ(seen.exit_code, 0);
  EXPECT_THAT(seen.output, HasSubstr("trefoil knot"));

  for (const auto& words : std::vector<std::vector<std::string>>{{"arm", "1"},
                                                                 {"cancel", "1"},
                                                                 {"speed", "1", "50"},
                                                                 {"move", "1"},
                                                                 {"submit", kSample}}) {
    // On a busy computer two may not have known one another in time.
    Ended refused;
    for (int i = 0; i < 5; ++i) {
      refused = Type(As(observer, words));
      EXPECT_NE(refused.exit_code, 0);
      if (refused.output.find("permissions") != std::string::npos) break;
    }
    EXPECT_THAT(refused.output, HasSubstr("permissions do not allow it"));
  }
  // To submit is one right; to arm, move and light is another one.
  const std::string submitter = keys_ / "submitter";
  const Ended given = Type(As(submitter, {"submit", kSample, "--height", "5"}));
  EXPECT_EQ(given.exit_code, 0) << given.output;
  for (const auto& words :
       std::vector<std::vector<std::string>>{{"arm", "1"},
                                             {"mount", "--block", "60", "60", "30"},
                                             {"teach", "jog", "x", "1"},
                                             {"teach", "lamp", "--for", "1"}}) {
    Ended refused;
    for (int i = 0; i < 5; ++i) {
      refused = Type(As(submitter, words));
      EXPECT_NE(refused.exit_code, 0) << words.front();
      if (refused.output.find("permissions") != std::string::npos) break;
    }
    EXPECT_THAT(refused.output, HasSubstr("permissions do not allow it"));
  }
  // A program without an identity discovers no participant.
  const Ended plain =
      Type({"list", "--domain", "46", "--tag", "secured" + std::to_string(getpid())});
  EXPECT_EQ(plain.exit_code, 2);

  const Ended cancelled = Type(As(operator_keys, {"cancel", "1"}));
  EXPECT_EQ(cancelled.exit_code, 0);
  EXPECT_TRUE(Eventually(
      [&] {
        return Type(As(observer, {"show", "1"})).output.find("cancelled") !=
               std::string::npos;
      },
      60s));
  up.Signal(SIGINT);
  EXPECT_EQ(up.WaitForEnd(30s).exit_code, 0);
}

TEST_F(SecuredShop, NoProgramLeavesLoopbackWithoutAnIdentity) {
  for (const char* program : {"intaglio-sorter", "intaglio-discretizer"}) {
    const Ended ended = Type({"--interface", "eth0", "--allow-root"}, program);
    EXPECT_EQ(ended.exit_code, 1);
    EXPECT_THAT(ended.output,
                AllOf(HasSubstr("--interface eth0"), HasSubstr("--security"),
                      HasSubstr("intaglio security new")));
  }
  const Ended list = Type({"list", "--interface", "eth0"});
  EXPECT_NE(list.exit_code, 0);
  EXPECT_THAT(list.output, HasSubstr("--security"));
}

TEST_F(SecuredShop, NoServiceServesANetworkAsRoot) {
  if (geteuid() != 0) GTEST_SKIP() << "only root is refused as root: run as root";
  const Ended ended =
      Type(As(keys_.string(), {"--interface", "eth0"}), "intaglio-sorter");
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_THAT(ended.output, HasSubstr("not as root"));
}

TEST_F(SecuredShop, AWrongRoleReportsWhichTopicItMayNotHave) {
  const Ended ended = Type(As(keys_ / "observer", {}), "intaglio-sorter");
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_THAT(ended.output, HasSubstr("ServiceHealth"));
  EXPECT_THAT(ended.output, HasSubstr("permissions do not allow it"));
}

// The message and the exit code; identity_test checks the files one by one.
TEST_F(SecuredShop, AMissingFileIsNamed) {
  fs::remove(keys_ / "stage-worker" / bus::kGovernanceFile);
  const Ended ended = Type(As(keys_.string(), {}), "intaglio-sorter");
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_THAT(ended.output, AllOf(HasSubstr("stage-worker/governance.p7s"),
                                  HasSubstr("No such file"), HasSubstr("copy")));
  EXPECT_EQ(Type({"security", "check", keys_.string(), "--domain", "46"}).exit_code, 2);
}

TEST_F(SecuredShop, AnIdentityThatEndsSoonIsAnAlarm) {
  ASSERT_EQ(Type({"security", "renew", keys_.string(), "--days", "5"}).exit_code, 0);
  Running sorter(Program("intaglio-sorter"), As(keys_.string(), {}),
                 folder_ / "sorter.txt");
  // Five days less what passed since, which may be less than a second.
  EXPECT_TRUE(Eventually(
      [&] {
        const std::string sent = sorter.Output();
        return sent.find("expires in 4 days") != std::string::npos ||
               sent.find("expires in 5 days") != std::string::npos;
      },
      60s))
      << sorter.Output();
  EXPECT_THAT(sorter.Output(), HasSubstr("identity_expires"));
}

TEST_F(SecuredShop, RenewsWhatItMade) {
  const fs::path key = keys_ / "operator" / bus::kPrivateKeyFile;
  const auto before = fs::last_write_time(key);
  EXPECT_EQ(Type({"security", "new", keys_.string()}).exit_code, 2);  // not over it
  EXPECT_EQ(Type({"security", "renew", keys_.string(), "--cell", "els-04"}).exit_code, 0);
  EXPECT_NE(fs::last_write_time(key), before);
  struct stat status = {};
  ASSERT_EQ(stat(key.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  const Ended all = Type({"security", "check", keys_.string(), "--domain", "46"});
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_THAT(all.output, HasSubstr("cell-els-04: good"));
}

}  // namespace
}  // namespace intaglio
