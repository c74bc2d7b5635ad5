// The units of deploy/systemd against what systemd makes of them, and against the options
// that the programs have.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <regex>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Program;
using testing::Running;
using testing::TextIn;

constexpr char kAnalyze[] = "/usr/bin/systemd-analyze";
// In tenths, as systemd-analyze takes it: below 2.0 it reports OK.
constexpr char kMaxExposed[] = "20";

class Units : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kAnalyze))
      GTEST_SKIP() << "no " << kAnalyze << ": install the package systemd";
    fs::copy(fs::path(INTAGLIO_SOURCE_DIR) / "deploy" / "systemd", folder_,
             fs::copy_options::recursive);
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().extension() != ".service") continue;
      // The programs are where they were built.
      const std::string text = std::regex_replace(
          TextIn(entry.path()), std::regex("/usr/bin"), INTAGLIO_BIN_DIR);
      std::ofstream(entry.path()) << text;
      std::string name = entry.path().filename().string();
      const auto at = name.find("@.");
      if (at != std::string::npos) name.insert(at + 1, "els-03");
      units_.push_back(name);
    }
    ASSERT_GE(units_.size(), 5u);
    // The manual pages that they name are those of the build.
    setenv("MANPATH", INTAGLIO_BIN_DIR "/../share/man", 1);
    setenv("SYSTEMD_UNIT_PATH", (folder_.string() + ":").c_str(), 1);
  }
  static std::string FileOf(const std::string& unit) {
    return std::regex_replace(unit, std::regex("@[^.]*"), "@");
  }
  Ended Analyze(std::vector<std::string> words) {
    Running run(kAnalyze, words, folder_ / "said.txt");
    return run.WaitForEnd(60s);
  }

  fs::path folder_ = test::FreshFolder();
  std::vector<std::string> units_;
};

TEST_F(Units, HaveNothingThatSystemdComplainsOf) {
  for (const std::string& unit : units_) {
    const Ended ended = Analyze({"verify", (folder_ / unit).string()});
    EXPECT_EQ(ended.exit_code, 0) << unit;
    EXPECT_EQ(ended.output.find(unit), std::string::npos) << ended.output;
  }
}

TEST_F(Units, LeaveLittleExposed) {
  for (const std::string& unit : units_) {
    const Ended ended =
        Analyze({"security", "--offline=true", "--no-pager",
                 std::string("--threshold=") + kMaxExposed, (folder_ / unit).string()});
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    const auto line = ended.output.rfind("Overall");
    ASSERT_NE(line, std::string::npos) << ended.output;
    std::cout << "  " << ended.output.substr(line);
  }
}

TEST_F(Units, GiveEveryProgramOptionsThatItHas) {
  const std::regex start("ExecStart=(\\S+)( [a-z]+)?(.*)"), flag("--[a-z-]+");
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string unit = TextIn(entry.path());
    std::smatch found;
    if (entry.path().extension() != ".service") continue;
    ASSERT_TRUE(std::regex_search(unit, found, start)) << entry.path();
    const std::string options = found[3];
    std::vector<std::string> words = {"--help"};
    if (found[2].matched) words.insert(words.begin(), found[2].str().substr(1));
    Running run(found[1].str(), words, folder_ / "said.txt");
    const Ended help = run.WaitForEnd(30s);
    EXPECT_EQ(help.exit_code, 0);
    for (std::sregex_iterator at(options.begin(), options.end(), flag), end; at != end;
         ++at) {
      EXPECT_THAT(help.output, ::testing::HasSubstr(at->str())) << entry.path();
    }
  }
}

// Devices are for who talks to the machine, real time for those, too, and for who renews
// the permission: asked of systemd, because a file that is read later may take back what
// one before it gave.
TEST_F(Units, OnlyTheCellsMayReachTheMachineAndOnlyWhoIsWaitedForIsInRealTime) {
  for (const std::string& unit : units_) {
    const bool of_cell = unit.find("-cell-") != std::string::npos;
    const bool in_real_time = of_cell || unit.find("job-service") != std::string::npos;
    const Ended ended =
        Analyze({"security", "--offline=true", "--no-pager", (folder_ / unit).string()});
    const auto reports = [&](const char* word) {
      return ended.output.find(word) != std::string::npos;
    };
    EXPECT_EQ(reports("\u2717 PrivateDevices="), of_cell) << unit << ended.output;
    EXPECT_EQ(reports("char-ttyUSB:rw"), of_cell) << unit << ended.output;
    EXPECT_EQ(reports("\u2717 RestrictRealtime="), in_real_time) << unit << ended.output;
    const std::string text = TextIn(folder_ / FileOf(unit));
    EXPECT_EQ(text.find("--real-time") != std::string::npos, in_real_time) << unit;
  }
}

// What was taught is saved in /etc, which is closed to all others.
TEST_F(Units, OnlyTheBridgeMaySaveWhatWasTaught) {
  for (const std::string& unit : units_) {
    std::string text = TextIn(folder_ / FileOf(unit));
    for (const char* part : {"intaglio-.service.d", "intaglio-cell-.service.d"}) {
      for (const auto& entry : fs::directory_iterator(folder_ / part))
        text += TextIn(entry.path());
    }
    EXPECT_NE(text.find("ProtectSystem=strict"), std::string::npos) << unit;
    const bool is_bridge = unit.find("cell-bridge") != std::string::npos;
    EXPECT_EQ(text.find("ReadWritePaths=-/etc/intaglio/machines") != std::string::npos,
              is_bridge)
        << unit;
    if (is_bridge) {
      EXPECT_NE(text.find("--machine /etc/intaglio/machines/%i.textproto"),
                std::string::npos);
    }
  }
}

// A unit without supervision must not fill a disk: recordings have a bound in size and in
// age. A file is removed whole, and never the one that is being written, so the bound
// holds several.
TEST_F(Units, TheRecorderKeepsNoMoreThanItsShare) {
  const std::string unit = TextIn(folder_ / "intaglio-recorder.service");
  const auto amount = [&unit](const std::string& flag) {
    std::smatch found;
    const bool there = std::regex_search(unit, found, std::regex(flag + " (\\d+)"));
    return there ? std::stod(found[1]) : 0.0;
  };
  EXPECT_GT(amount("--split-mb"), 0);
  EXPECT_GE(amount("--keep-mb"), 4 * amount("--split-mb"));
  EXPECT_GT(amount("--keep-h"), 24);
}

/// Where systemd would listen to a service.
class NotifySocket {
 public:
  explicit NotifySocket(const fs::path& path)
      : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    bound_ = bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
    const timeval patience{0, 100'000};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~NotifySocket() {
    unsetenv("NOTIFY_SOCKET");
    close(fd_);
  }
  bool bound() const { return bound_; }
  /// Whether it comes within the time; what else comes is thrown away.
  bool Source(const std::string& word, std::chrono::seconds bound) const {
    return testing::Eventually(
        [&] {
          char text[512] = {};
          const ssize_t size = recv(fd_, text, sizeof text - 1, 0);
          return size > 0 && std::string(text).find(word) != std::string::npos;
        },
        bound);
  }

 private:
  int fd_;
  bool bound_ = false;
};

TEST(Service, NotifiesItsInitSystemOfItsState) {
  const fs::path folder = test::FreshFolder();
  // A path of a socket may have 107 letters, and a build folder more.
  const fs::path path =
      fs::temp_directory_path() / ("intaglio-notify-" + std::to_string(getpid()));
  const NotifySocket system(path);
  ASSERT_TRUE(system.bound()) << path;
  Running sorter(Program("intaglio-sorter"),
                 {"--tag", "notify" + std::to_string(getpid())}, folder / "said.txt");
  EXPECT_TRUE(system.Source("READY=1", 30s)) << sorter.Output();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(system.Source("WATCHDOG=1", 10s));
  sorter.Signal(SIGSTOP);  // a loop that does not turn sends no notification
  while (system.Source("WATCHDOG=1", 1s)) {
  }  // what was under way; then a second of silence
  sorter.Signal(SIGCONT);
  EXPECT_TRUE(system.Source("WATCHDOG=1", 10s));
  sorter.Signal(SIGTERM);
  EXPECT_TRUE(system.Source("STOPPING=1", 10s));
  EXPECT_EQ(sorter.WaitForEnd(30s).exit_code, 0);
  fs::remove(path);
}

}  // namespace
}  // namespace intaglio
