// Faults by the dozen, at seeded random instants of real jobs through real processes,
// each in a cell of its own; the glass is held against the journal point by point.
//
//   campaign FAULT [--runs N] [--seed S] [--speed N] [--keep]
//   campaign soak [--hours H] [--seed S] [--if-long]
//   campaign machine NAME [FAULT] [--runs N] [--seed S] [--keep]
//   campaign scale [CELLS]...
//
// soak: job after job in one shop, with faults, over so many hours of engraving at 1 Hz;
// what the services hold is not to grow (soak.h). --if-long: only with INTAGLIO_LONG=1,
// else it ends with 77.
//
// machine: grbl-points, grbl-laser, mill, scan-head; the record of their controllers'
// true places is the judge (machine_campaign.h).
//
// scale: no faults, but what shops of so many idle machines cost (scale.h).
//
// Ends with 0 when no run doubled a point, lost one, or did not come to its end.

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <random>

#include "tests/integration/campaign/cell_under_fire.h"
#include "tests/integration/campaign/machine_campaign.h"
#include "tests/integration/campaign/scale.h"
#include "tests/integration/campaign/soak.h"
#include "tests/integration/campaign/stop_button.h"
#include "tests/test_folder.h"

namespace {

using namespace intaglio;
using namespace intaglio::campaign;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kPoints = 400;  // a little less than the job has
constexpr auto kBound = 90s;

double Milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

/// One run: what was done to the cell, and how long it took until no crack came any more.
struct Outcome {
  Verdict verdict;
  bool done = false;
  double beam_off_ms = -1;  ///< -1: not asked for
};

/// Until the glass has been still for longer than anything that is under way takes.
double StillAfter(const CellUnderFire& cell, Clock::time_point from) {
  auto last = from;
  std::size_t cracks = cell.Cracks();
  while (Clock::now() - last < 700ms && Clock::now() - from < 3s) {
    const std::size_t now = cell.Cracks();
    if (now != cracks) {
      cracks = now;
      last = Clock::now();
    }
    usleep(500);
  }
  return Milliseconds(last - from);
}

using Fault = std::function<void(CellUnderFire&, std::mt19937&, Outcome&)>;

Fault KillOf(const std::string& service) {
  return [service](CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
    const pid_t victim = cell.ProcessOf(service);
    const auto at = Clock::now();
    if (victim > 0) kill(victim, SIGKILL);
    // Who is not needed any more costs nothing.
    const bool matters =
        service != "intaglio-discretizer" && service != "intaglio-sorter";
    if (matters) outcome.beam_off_ms = StillAfter(cell, at);
    outcome.done = cell.AwaitDone(kBound);
  };
}

void KillAll(CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
  const auto at = Clock::now();
  cell.KillShop();
  outcome.beam_off_ms = StillAfter(cell, at);
  cell.AwaitShopGone();
  outcome.done = cell.OpenShop() && cell.AwaitDone(kBound);
}

/// All are killed, and a disk that had confirmed what it did not have loses the end of
/// the journal at any byte. The operator inspects the block and leaves the uncertain
/// points.
void LoseTheJournalsEnd(CellUnderFire& cell, std::mt19937& random, Outcome& outcome) {
  const auto at = Clock::now();
  cell.KillShop();
  outcome.beam_off_ms = StillAfter(cell, at);
  cell.AwaitShopGone();
  cell.CutJournal(random());
  outcome.verdict.may_leave_uncertain = true;
  outcome.done = cell.OpenShop() && cell.AwaitDoneResuming(kBound);
}

/// What a person has to see to: the operator sets it right, and resumes.
Fault PressAndSetRight(const std::string& wrong, const std::string& right) {
  return [wrong, right](CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
    const auto at = Clock::now();
    cell.Press(wrong);
    outcome.beam_off_ms = StillAfter(cell, at);
    const std::size_t cracks = cell.Cracks();
    cell.Press(right);
    usleep(1'500'000);
    if (cell.Cracks() != cracks) {
      outcome.verdict.trouble = "it went on without a new arm";
      return;
    }
    outcome.done = cell.AwaitDoneResuming(kBound);
  };
}

/// The emergency stop on the bus, with other listeners that do not read.
Fault StopOnTheBus(int watchers) {
  return [watchers](CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
    cell.AddFrozenWatchers(watchers);
    StopButton button(cell.bus_options(), cell.cell());
    if (!button.AwaitReceived(10s)) {
      outcome.verdict.trouble = "nobody hears the stop";
      return;
    }
    if (!cell.AwaitCracks(cell.Cracks() + 2, 500ms)) {
      outcome.verdict.trouble = "nothing is engraved any more: take a lower --speed";
      return;
    }
    const auto at = Clock::now();
    button.Press();
    outcome.beam_off_ms = StillAfter(cell, at);
    const std::size_t cracks = cell.Cracks();
    button.Reset();
    usleep(1'500'000);
    if (cell.Cracks() != cracks) {
      outcome.verdict.trouble = "it went on without a new arm";
      return;
    }
    outcome.done = cell.AwaitDoneResuming(kBound);
  };
}

/// The door is opened and shut while no process runs that could detect it.
void OpenTheDoorUnseen(CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
  const pid_t victim = cell.ProcessOf("intaglio-synchronizer");
  const auto at = Clock::now();
  if (victim > 0) kill(victim, SIGKILL);
  cell.Press("door force");  // the shutter may be open, and the door locked
  cell.Press("door close");
  outcome.beam_off_ms = StillAfter(cell, at);
  const std::size_t cracks = cell.Cracks();
  usleep(5'000'000);
  if (cell.Cracks() != cracks) {
    outcome.verdict.trouble = "it went on without a new arm";
    return;
  }
  outcome.done = cell.AwaitDoneResuming(kBound);
}

/// For longer than lamp, services and every renewal of a permission take.
void ExpectNoCrack(const std::function<std::size_t()>& cracks, Outcome& outcome) {
  const std::size_t before = cracks();
  usleep(4'000'000);
  if (cracks() != before) outcome.verdict.trouble = "it fired without a new arm";
}

/// The machine and its cell lose their power, and the block is another one afterwards.
/// The job service lives, and the shop starts the cell's services again.
void PowerCycle(CellUnderFire& cell, std::mt19937& random, Outcome& outcome) {
  for (const char* service : {"intaglio-synchronizer", "intaglio-motion-bridge"}) {
    if (const pid_t victim = cell.ProcessOf(service); victim > 0) kill(victim, SIGKILL);
  }
  usleep(random() % 3'000'000);
  cell.ChangeTheBlockOfADeadMachine();
  ExpectNoCrack([&cell] { return cell.CracksOfTheNextBlock(); }, outcome);
  if (cell.CracksOfTheNextBlock() > 0) outcome.verdict.trouble = "it fired by itself";
  // The points that were armed when the power failed are uncertain.
  outcome.verdict.may_leave_uncertain = true;
  outcome.verdict.may_be_unfinished = true;
  // It waits for a person, or has nothing left that anybody may fire.
  const std::string shown = cell.Show();
  outcome.done = shown.find("state      paused") != std::string::npos ||
                 shown.find("state      done") != std::string::npos;
}

bool AwaitState(CellUnderFire& cell, const std::string& state) {
  return intaglio::testing::Eventually(
      [&] { return cell.Show().find("state      " + state) != std::string::npos; }, 30s);
}

/// The job is armed, its points are not in order yet.
void OpenTheDoorBeforeThePath(CellUnderFire& cell, std::mt19937& random,
                              Outcome& outcome) {
  cell.Press("door open");
  usleep(random() % 500'000);
  cell.Press("door close");
  if (!AwaitState(cell, "paused") && !AwaitState(cell, "waiting for arm")) return;
  ExpectNoCrack([&cell] { return cell.Cracks(); }, outcome);
  outcome.done = cell.AwaitDoneResuming(kBound);
}

/// The job is armed, loses its sorter, and another one gets its machine before it.
void Overtake(CellUnderFire& cell, std::mt19937&, Outcome& outcome) {
  if (const pid_t victim = cell.ProcessOf("intaglio-sorter"); victim > 0) {
    kill(victim, SIGKILL);
  }
  cell.SubmitAnother({"--priority", "1"});
  usleep(2'000'000);
  cell.Type({"cancel", "2"});
  if (!AwaitState(cell, "waiting for arm")) return;
  ExpectNoCrack([&cell] { return cell.Cracks(); }, outcome);
  outcome.done = cell.Type({"arm", "1"}).empty() || cell.AwaitDoneResuming(kBound);
}

Fault PressForAWhile(const std::string& wrong, const std::string& right) {
  return [wrong, right](CellUnderFire& cell, std::mt19937& random, Outcome& outcome) {
    cell.Press(wrong);
    usleep(100'000 + random() % 2'000'000);
    cell.Press(right);
    outcome.done = cell.AwaitDone(kBound);
  };
}

Fault StopFor(const std::string& service) {
  return [service](CellUnderFire& cell, std::mt19937& random, Outcome& outcome) {
    const pid_t victim = cell.ProcessOf(service);
    if (victim > 0) kill(victim, SIGSTOP);
    usleep(50'000 + random() % 5'000'000);
    if (victim > 0) kill(victim, SIGCONT);
    outcome.done = cell.AwaitDone(kBound);
  };
}

const std::map<std::string, Fault>& Faults() {
  static const std::map<std::string, Fault> faults = {
      {"kill-job-service", KillOf("intaglio-job-service")},
      {"kill-discretizer", KillOf("intaglio-discretizer")},
      {"kill-sorter", KillOf("intaglio-sorter")},
      {"kill-synchronizer", KillOf("intaglio-synchronizer")},
      {"kill-motion-bridge", KillOf("intaglio-motion-bridge")},
      {"kill-all", KillAll},
      {"power-loss", LoseTheJournalsEnd},
      {"freeze-synchronizer", StopFor("intaglio-synchronizer")},
      {"freeze-motion-bridge", StopFor("intaglio-motion-bridge")},
      {"freeze-job-service", StopFor("intaglio-job-service")},
      {"emergency-stop", PressAndSetRight("estop press", "estop release")},
      {"stop-on-the-bus", StopOnTheBus(0)},
      {"stop-on-the-bus-watchers-frozen", StopOnTheBus(3)},
      {"door", PressAndSetRight("door force", "door close")},
      {"door-unseen", OpenTheDoorUnseen},
      {"door-before-the-path", OpenTheDoorBeforeThePath},
      {"overtaken", Overtake},
      {"power-cycle", PowerCycle},
      {"key", PressAndSetRight("key off", "key on")},
      {"unplug-laser", PressForAWhile("unplug laser", "plug laser")},
      {"unplug-motion", PressForAWhile("unplug motion", "plug motion")},
      {"drop-bytes-laser",
       PressForAWhile("drop-bytes 0.002 laser", "drop-bytes 0 laser")},
      {"drop-bytes-motion",
       PressForAWhile("drop-bytes 0.002 motion", "drop-bytes 0 motion")},
  };
  return faults;
}

/// It happens while an armed job is put in order.
bool IsBeforeThePath(const std::string& fault) {
  return fault == "door-before-the-path" || fault == "overtaken";
}

struct Options {
  std::string fault;
  int runs = 3;
  unsigned seed = 1;
  double speed = 4;
  double hours = 1;
  bool keep = false;
  bool if_long = false;
  std::string profile = "els-03";
};
constexpr int kSkipped = 77;

Outcome RunOnce(const Options& options, int run, std::mt19937& random) {
  const auto folder =
      test::FreshFolder(fmt::format("campaign-{}-{}", options.fault, getpid()));
  Outcome outcome;
  {
    CellUnderFire cell(folder, fmt::format("campaign-{}-{}", getpid(), run),
                       fmt::format("{}", options.speed), options.profile);
    const std::size_t at = 1 + random() % kPoints;
    const bool early = IsBeforeThePath(options.fault);
    const bool begun =
        cell.OpenShop() &&
        (early ? cell.Submit("", {"--order-time", "4"}) && AwaitState(cell, "ordering")
               : cell.Submit() && cell.AwaitCracks(at, 60s));
    if (!begun) {
      outcome.verdict.trouble = "the job did not begin: " + cell.Show();
      return outcome;
    }
    Faults().at(options.fault)(cell, random, outcome);
    const Verdict sent = outcome.verdict;
    outcome.verdict = cell.Judge();
    outcome.verdict.may_leave_uncertain = sent.may_leave_uncertain;
    outcome.verdict.may_be_unfinished = sent.may_be_unfinished;
    if (!sent.trouble.empty()) outcome.verdict.trouble = sent.trouble;
    if (!outcome.done) outcome.verdict.trouble += " not done: " + cell.Show();
  }
  if (!options.keep && outcome.verdict.good()) std::filesystem::remove_all(folder);
  return outcome;
}

int RunCampaign(const Options& options) {
  std::mt19937 random(options.seed);
  std::vector<double> beam_off_ms;
  std::size_t points = 0, made = 0, doubled = 0, stray = 0, unknown = 0, uncertain = 0;
  int completed = 0, good = 0;
  for (int run = 0; run < options.runs; ++run) {
    const Outcome outcome = RunOnce(options, run, random);
    const Verdict& v = outcome.verdict;
    points += v.points, made += v.made, doubled += v.doubled, stray += v.stray;
    unknown += v.unknown, uncertain += v.uncertain;
    completed += outcome.done ? 1 : 0;
    good += v.good() ? 1 : 0;
    if (outcome.beam_off_ms >= 0) beam_off_ms.push_back(outcome.beam_off_ms);
    if (!v.good()) {
      std::cerr << fmt::format(
          "seed {}, run {}: {} of {} made, {} doubled, {} stray, {} "
          "unknown, {} uncertain; {}\n",
          options.seed, run, v.made, v.points, v.doubled, v.stray, v.unknown, v.uncertain,
          v.trouble);
    }
  }
  std::sort(beam_off_ms.begin(), beam_off_ms.end());
  const std::string off =
      beam_off_ms.empty()
          ? "-"
          : fmt::format("{:.0f} / {:.0f}", beam_off_ms[beam_off_ms.size() / 2],
                        beam_off_ms.back());
  std::cout << fmt::format("| {} | {} | {} | {} of {} | {} | {} | {} | {} | {} |\n",
                           options.fault, options.runs, completed, made, points, doubled,
                           stray, unknown, uncertain, off);
  return good == options.runs ? 0 : 1;
}

int Usage() {
  std::cerr
      << "campaign soak [--hours H] [--seed S] [--if-long], or\n"
         "campaign FAULT [--runs N] [--seed S] [--speed N] [--profile NAME] [--keep], a "
         "row "
         "of\n"
         "| fault | runs | completed | made | doubled | stray | unknown | uncertain "
         "| last crack after, ms (median / most) |\nFAULT:";
  for (const auto& [name, fault] : Faults()) std::cerr << ' ' << name;
  std::cerr << "\nor campaign machine NAME [FAULT] [--runs N] [--seed S] [--keep], a row "
               "of\n| machine | runs | ended | without a grant | made | doubled | stray "
               "| unknown | uncertain |\nNAME:"
            << MachineNames()
            << "\nor campaign scale [CELLS]..., the cost of shops of so many idle "
               "machines\n";
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--keep") {
      options.keep = true;
    } else if (word == "--if-long") {
      options.if_long = true;
    } else if (word.starts_with("--") && i + 1 < argc) {
      const double value = std::strtod(argv[++i], nullptr);
      if (word == "--profile") options.profile = argv[i];
      if (word == "--runs") options.runs = static_cast<int>(value);
      if (word == "--seed") options.seed = static_cast<unsigned>(value);
      if (word == "--speed") options.speed = value;
      if (word == "--hours") options.hours = value;
    } else {
      words.push_back(word);
    }
  }
  if (words.size() >= 2 && words[0] == "machine") {
    const int code = RunMachineCampaign({words[1], words.size() > 2 ? words[2] : "",
                                         options.runs, options.seed, options.keep});
    return code == 2 ? Usage() : code;
  }
  if (!words.empty() && words[0] == "scale") {
    const int code = RunScale({words.begin() + 1, words.end()});
    return code == 2 ? Usage() : code;
  }
  if (!words.empty()) options.fault = words.front();
  if (options.fault == "soak") {
    if (options.if_long && std::getenv("INTAGLIO_LONG") == nullptr) return kSkipped;
    return RunSoak({options.hours, options.seed});
  }
  if (!Faults().contains(options.fault) || options.runs < 1) return Usage();
  return RunCampaign(options);
}
