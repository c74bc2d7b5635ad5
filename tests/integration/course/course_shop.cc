#include "tests/integration/course/course_shop.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <thread>

#include "engrave/mark/mark_file.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct ShopMachine {
  const char* profile;
  const char* device;  ///< in the profile
  const char* controller;
  std::vector<std::string> words = {};
};

const ShopMachine& MachineOf(CourseShop::Machine machine) {
  static const std::array<ShopMachine, 3> machines = {
      ShopMachine{"mill", "/dev/ttyUSB0", "virtual-grbl", {"--hal", "--spindle"}},
      ShopMachine{"laser-cutter", "/dev/ttyUSB0", "virtual-grbl", {"--hal"}},
      ShopMachine{"bjjcz", "usb:9588:9899", "virtual-bjjcz", {"--guide", "8"}}};
  return machines[static_cast<std::size_t>(machine)];
}

// The supplied one, with the line, and a spindle that turns after a second.
std::string ProfileOf(const ShopMachine& machine, const std::string& line) {
  std::string profile = TextIn(std::string(INTAGLIO_SOURCE_DIR "/deploy/machines/") +
                               machine.profile + ".textproto");
  const std::string device = machine.device;
  profile.replace(profile.find(device), device.size(), line);
  const std::string spin_up = "spin_up_s: 4";
  if (const auto at = profile.find(spin_up); at != std::string::npos)
    profile.replace(at, spin_up.size(), "spin_up_s: 1");
  return profile;
}

}  // namespace

CourseShop::CourseShop(Machine machine)
    : folder_(test::FreshFolder()), tag_("course" + std::to_string(getpid())) {
  const std::string line = (folder_ / "line").string();
  const ShopMachine& made = MachineOf(machine);
  Write("machine.textproto", ProfileOf(made, line));
  std::vector<std::string> words = {"--line",       line,      "--record",
                                    board_record(), "--panel", folder_ / "panel"};
  words.insert(words.end(), made.words.begin(), made.words.end());
  if (machine != Machine::kBoard)
    words.insert(words.end(), {"--way", folder_ / "way.txt"});
  controller_ = std::make_unique<Running>(
      fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests" / made.controller, words,
      folder_ / "controller.log");
  EXPECT_TRUE(Eventually([&] { return fs::exists(line); }, 20s));
}

CourseShop::~CourseShop() { Close(); }

void CourseShop::Close() {
  if (!IsOpen()) return;
  up_->Signal(SIGTERM);
  up_->WaitForEnd(20s);
}

void CourseShop::Write(const std::string& name, const std::string& text) const {
  std::ofstream(folder_ / name) << text;
}

fs::path CourseShop::WriteJob(const std::string& name, const std::string& fields) const {
  Write(name + ".textproto", "name: \"" + name +
                                 "\" machine_file: \"machine.textproto\" course { " +
                                 fields + " }\n");
  return folder_ / (name + ".textproto");
}

bool CourseShop::Open() {
  up_.reset();
  up_ = std::make_unique<Running>(
      Program("intaglio"),
      std::vector<std::string>{
          "up", "--real-machine", "--machine", folder_ / "machine.textproto", "--folder",
          folder_ / "shop", "--materials", folder_ / "materials.db", "--piece",
          "copper-clad FR4", "--domain", "49", "--tag", tag_},
      folder_ / ("up" + std::to_string(++opened_) + ".log"));
  const auto is_open = [&] {
    return up_->Output().find("the shop is open") != std::string::npos;
  };
  return Eventually([&] { return !up_->running() || is_open(); }, 60s) && up_->running();
}

std::vector<std::string> CourseShop::With(std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", "49", "--tag", tag_});
  return words;
}

std::string CourseShop::Type(std::vector<std::string> words) const {
  Running run(Program("intaglio"), With(std::move(words)), folder_ / "typed.txt");
  return run.WaitForEnd(60s).output;
}

std::string CourseShop::Teach(std::vector<std::string> words) const {
  words.insert(words.begin(), "teach");
  std::string answer;
  for (int i = 0; i < 20; ++i) {
    answer = Type(words);
    const bool again = answer.find("let go") != std::string::npos ||
                       answer.find("not answer") != std::string::npos;
    if (!again) break;
    std::this_thread::sleep_for(500ms);
  }
  return answer;
}

bool CourseShop::Submit(const fs::path& job) const {
  const std::string answer = Type({"submit", job, "--arm"});
  EXPECT_NE(answer.find("job "), std::string::npos) << answer;
  return answer.find("job ") != std::string::npos;
}

bool CourseShop::AwaitState(const std::string& state, std::chrono::seconds bound) {
  return Eventually(
      [&] {
        shown_ = Type({"show", "1"});
        return shown_.find("state      " + state) != std::string::npos;
      },
      bound);
}

void CourseShop::GoOn() {
  shown_ = Type({"show", "1"});
  if (shown_.find("state      paused") != std::string::npos) Type({"resume", "1"});
  if (shown_.find("state      waiting for arm") != std::string::npos) Type({"arm", "1"});
}

bool CourseShop::AwaitDone(std::chrono::seconds bound) {
  return Eventually(
      [&] {
        if (!IsOpen() && !Open()) return false;
        GoOn();
        return shown_.find("state      done") != std::string::npos;
      },
      bound);
}

void CourseShop::AtPanel(const std::string& command) const {
  EXPECT_EQ(AskPanel(folder_, command), "ok\n") << command;
}

std::size_t CourseShop::Lapses() const {
  const std::string log = TextIn(folder_ / "shop" / "marker.log");
  std::size_t count = 0;
  for (const char* sign :
       {"too busy to permit it", "the line to the controller is down"}) {
    for (auto at = log.find(sign); at != std::string::npos; at = log.find(sign, at + 1))
      ++count;
  }
  return count;
}

int CourseShop::Signal(const std::string& service, int signal) const {
  int sent = 0;
  for (const pid_t process : ProcessesWith({"/" + service, tag_}))
    sent += kill(process, signal) == 0;
  return sent;
}

fs::path CourseShop::JobFolder() const {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs", none))
    if (entry.path().filename().string().starts_with("1-")) return entry.path();
  return {};
}

mark::MarkSet CourseShop::Marks() const {
  const auto marks = mark::ReadMarkFile(JobFolder() / "marks.bin");
  EXPECT_TRUE(marks) << marks.error().message;
  return marks ? *marks : mark::MarkSet();
}

std::vector<formats::PointOutcome> CourseShop::Outcomes(std::size_t count) const {
  std::vector<formats::PointOutcome> last(count, formats::PointOutcome::kNone);
  const auto journal = formats::ReadJournal(JobFolder() / "journal.bin");
  EXPECT_TRUE(journal);
  if (!journal) return last;
  for (const formats::JournalRecord& one : journal->records)
    if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  return last;
}

}  // namespace intaglio::testing
