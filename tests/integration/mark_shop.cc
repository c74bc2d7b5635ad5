#include "tests/integration/mark_shop.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <set>

#include "engrave/formats/mark_record.h"

namespace intaglio::testing {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using formats::PointOutcome;

namespace {

constexpr auto kOpenBound = 60s;

/// Each shop of this process has its own.
std::string NextTag() {
  static int number = 0;
  return "marks" + std::to_string(getpid()) + "-" + std::to_string(++number);
}

}  // namespace

std::string CirclesSvg(std::size_t count) {
  constexpr std::size_t kColumns = 20;
  std::string svg = R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" )"
                    R"(height="40mm" viewBox="0 0 40 40">)";
  for (std::size_t i = 0; i < count; ++i) {
    svg += "<circle cx=\"" + std::to_string(1 + 2 * (i % kColumns)) + "\" cy=\"" +
           std::to_string(1 + 2 * (i / kColumns)) + "\" r=\"0.5\"/>";
  }
  return svg + "</svg>";
}

MarkShop::MarkShop(Options options, fs::path folder)
    : options_(std::move(options)), folder_(std::move(folder)), tag_(NextTag()) {
  std::ofstream(folder_ / "job.textproto") << "machine_file: \"shop/machine.textproto\"\n"
                                           << options_.job;
  fs::create_directory(folder_ / "shop");
  fs::copy_file(fs::path(INTAGLIO_SOURCE_DIR "/deploy/machines") /
                    (options_.profile + ".textproto"),
                folder_ / "shop/machine.textproto");
}

MarkShop::~MarkShop() {
  if (!IsOpen()) return;
  up_->Signal(SIGTERM);
  up_->WaitForEnd(20s);
}

std::vector<std::string> MarkShop::With(std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", "49", "--tag", tag_});
  return words;
}

bool MarkShop::Open() {
  up_.reset();
  // Those of a shop that was killed, which end with it.
  Eventually([this] { return ProcessesWith({tag_}).empty(); }, 20s);
  std::vector<std::string> words = {"up",
                                    "--folder",
                                    (folder_ / "shop").string(),
                                    "--materials",
                                    (folder_ / "materials.db").string(),
                                    "--machine",
                                    (folder_ / "shop/machine.textproto").string()};
  words.insert(words.end(), options_.up.begin(), options_.up.end());
  up_ = std::make_unique<Running>(Program("intaglio"), With(std::move(words)),
                                  folder_ / ("up" + std::to_string(++opened_) + ".log"));
  return Eventually(
             [this] {
               return !up_->running() ||
                      up_->Output().find("the shop is open") != std::string::npos;
             },
             kOpenBound) &&
         up_->running();
}

std::string MarkShop::Type(const std::vector<std::string>& words) {
  Running run(Program("intaglio"), With(words), folder_ / "typed.txt");
  return run.WaitForEnd(60s).output;
}

bool MarkShop::Submit() {
  return Type({"submit", (folder_ / "job.textproto").string(), "--arm"}).find("job 1") !=
         std::string::npos;
}

const std::string& MarkShop::Show() { return shown_ = Type({"show", "1"}); }

bool MarkShop::IsIn(const std::string& state) const {
  return shown_.find("state      " + state) != std::string::npos;
}

bool MarkShop::AwaitDone(std::chrono::seconds bound) {
  return Eventually(
      [&] {
        if (!IsOpenOrOpens()) return false;
        Show();
        if (IsIn("paused") || IsIn("waiting")) Type({"resume", "1"});
        return IsIn("done");
      },
      bound);
}

int MarkShop::Kill(const std::string& program) {
  if (program == "intaglio-up") {
    const bool is_open = IsOpen();
    if (is_open) up_->Signal(SIGKILL);
    return is_open ? 1 : 0;
  }
  // The machine is on no bus: it has the folder in place of the tag.
  const std::string ours = program == "virtual-engraver" ? folder_.string() : tag_;
  const auto processes = ProcessesWith({"/" + program, ours});
  for (const pid_t process : processes) kill(process, SIGKILL);
  return static_cast<int>(processes.size());
}

std::size_t MarkShop::BurntTicks() const {
  const auto record = formats::ReadMarkRecord(folder_ / "shop/marks.rec");
  return record ? record->ticks.size() : 0;
}

MarkJudgement MarkShop::Judge() const {
  MarkJudgement judgement;
  std::map<std::uint32_t, std::set<std::pair<fs::path, std::uint32_t>>> runs_of;
  for (const fs::path& file : Records()) {
    const auto record = formats::ReadMarkRecord(file);
    EXPECT_TRUE(record) << file;
    if (!record) continue;
    for (const formats::BurntTick& tick : record->ticks)
      runs_of[tick.mark].insert({file, tick.run});
  }
  const auto outcomes = LastOutcomes();
  judgement.burnt = runs_of.size();
  for (std::uint32_t mark = 0; mark < options_.mark_count; ++mark) {
    const bool burnt = runs_of.contains(mark);
    const PointOutcome outcome = outcomes.at(mark);
    judgement.doubled += burnt && runs_of.at(mark).size() > 1;
    judgement.made += outcome == PointOutcome::kMade;
    judgement.uncertain += outcome == PointOutcome::kUncertain;
    judgement.unknown +=
        burnt && outcome != PointOutcome::kMade && outcome != PointOutcome::kUncertain;
    judgement.not_made += !burnt && outcome == PointOutcome::kMade;
  }
  return judgement;
}

std::vector<fs::path> MarkShop::Records() const {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop"))
    if (entry.path().filename().string().starts_with("marks"))
      files.push_back(entry.path());
  return files;
}

std::vector<PointOutcome> MarkShop::LastOutcomes() const {
  std::vector<PointOutcome> last(options_.mark_count, PointOutcome::kNone);
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
    if (!entry.path().filename().string().starts_with("1-")) continue;
    const auto journal = formats::ReadJournal(entry.path() / "journal.bin");
    EXPECT_TRUE(journal);
    if (!journal) continue;
    for (const formats::JournalRecord& one : journal->records)
      if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  }
  return last;
}

}  // namespace intaglio::testing
