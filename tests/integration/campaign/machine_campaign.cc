#include "tests/integration/campaign/machine_campaign.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <random>
#include <thread>

#include "tests/integration/campaign/machine_under_fire.h"
#include "tests/test_folder.h"

namespace intaglio::campaign {
namespace {

using namespace std::chrono_literals;
using testing::Eventually;

// A contour is ended, the line runs dry, and a process that was lost is there again.
constexpr std::chrono::milliseconds kSettles{1500}, kRestarts{5000};
// An automatic arm behind a lost line takes three seconds at most.
constexpr auto kQuiet = 4s;
constexpr auto kJobBound = 90s;

struct Run {
  double at = 0;  ///< amount of work before the fault
  Account account;
  bool done = false;
  bool was_quiet = true;  ///< nothing without a fresh grant
  std::string trouble;

  bool good() const {
    return trouble.empty() && done && was_quiet && account.items > 0 &&
           account.doubled + account.stray + account.unknown == 0 &&
           account.made + account.uncertain >= account.items;
  }
};

/// Something happened in this time that nobody has permitted.
void ExpectQuiet(const MachineUnderFire& fire, std::uintmax_t before,
                 std::chrono::milliseconds time, const char* without, Run& run) {
  const std::string pointed = fire.Mirrors();
  std::this_thread::sleep_for(time);
  const std::uintmax_t now = fire.Activity();
  const std::string points = fire.Mirrors();
  if (now == before && points == pointed) return;
  run.was_quiet = false;
  run.trouble += fmt::format("acted without {}: record {} -> {} bytes {} {}; ", without,
                             before, now, pointed, points);
}

/// The fault, and what a person does until the job is done.
void Strike(MachineUnderFire& fire, const MachineRow& machine, const FaultRow& fault,
            Run& run) {
  const bool restarts = fault.by == FaultRow::By::kKill;
  fire.Act(fault);
  std::this_thread::sleep_for(restarts ? kRestarts : kSettles);
  const std::uintmax_t settled = fire.Activity();
  fire.SetRight(fault);
  if (NeedsPerson(machine, fault)) ExpectQuiet(fire, settled, kQuiet, "a grant", run);
  if (LosesPlace(machine, fault)) {
    const std::uintmax_t before = fire.Activity();
    fire.Type("resume 1");
    ExpectQuiet(fire, before, kQuiet, "a zero", run);
    if (const std::string refused = fire.SetZero(); !refused.empty())
      run.trouble += refused + "; ";
  }
  run.done = fire.AwaitDone(kJobBound);
  if (!run.done) run.trouble += "not done: " + fire.Show();
}

bool Begin(MachineUnderFire& fire, double at) {
  if (!fire.OpenShop() || !fire.Submit()) return false;
  return Eventually(
      [&] {
        if (AmountOf(fire.Work()) >= at) return true;
        std::this_thread::sleep_for(20ms);
        fire.GoOn();
        return false;
      },
      60s);
}

Run RunOnce(const MachineCampaign& campaign, const MachineRow& machine,
            const FaultRow& fault, int number, std::mt19937& random) {
  const std::string name =
      fmt::format("campaign-{}-{}-{}", machine.name, getpid(), number);
  const auto folder = test::FreshFolder(name);
  Run run;
  // Not at the very end, and so late that the height of points is known.
  run.at = machine.amount * std::uniform_real_distribution(0.08, 0.85)(random);
  const std::chrono::milliseconds later(random() % 200);
  try {
    MachineUnderFire fire(machine, folder, name);
    if (!Begin(fire, run.at)) {
      run.trouble = "the job did not begin: " + fire.Show() + fire.Log();
      return run;
    }
    const auto before = fire.Work();
    std::this_thread::sleep_for(later);
    Strike(fire, machine, fault, run);
    if (const auto account = fire.Judge(before))
      run.account = *account;
    else
      run.trouble += account.error().message;
  } catch (const std::exception& error) {
    run.trouble += error.what();
  }
  if (!campaign.keep && run.good()) std::filesystem::remove_all(folder);
  return run;
}

std::vector<FaultRow> FaultsOf(const MachineCampaign& campaign, const MachineRow& machine,
                               std::mt19937& random) {
  std::vector<FaultRow> faults;
  for (const FaultRow& fault : FaultRows()) {
    const bool asked = campaign.fault.empty() || campaign.fault == fault.name;
    if (asked && HasFault(machine, fault)) faults.push_back(fault);
  }
  std::shuffle(faults.begin(), faults.end(), random);
  return faults;
}

void Print(const Run& run, const FaultRow& fault, const MachineCampaign& campaign,
           int number) {
  const Account& a = run.account;
  std::cout << fmt::format(
                   "seed {}, run {}: {} after {:.1f}: {} of {} made, {} uncertain, {} "
                   "doubled, {} stray ({:.3f} mm), {} unknown{}{}",
                   campaign.seed, number, fault.name, run.at, a.made, a.items,
                   a.uncertain, a.doubled, a.stray, a.stray_mm, a.unknown,
                   run.good() ? "" : ": BAD; ", run.trouble)
            << std::endl;
}

}  // namespace

std::string MachineNames() {
  std::string names;
  for (const MachineRow& row : MachineRows()) names += fmt::format(" {}", row.name);
  return names;
}

int RunMachineCampaign(const MachineCampaign& campaign) {
  const auto& rows = MachineRows();
  const auto machine = std::ranges::find_if(
      rows, [&](const MachineRow& row) { return campaign.machine == row.name; });
  if (machine == rows.end()) return 2;
  std::mt19937 random(campaign.seed);
  const auto faults = FaultsOf(campaign, *machine, random);
  if (faults.empty()) return 2;
  Account sum;
  int done = 0, good = 0, unasked = 0;
  for (int i = 0; i < campaign.runs; ++i) {
    const FaultRow& fault = faults[static_cast<std::size_t>(i) % faults.size()];
    const Run run = RunOnce(campaign, *machine, fault, i, random);
    Print(run, fault, campaign, i);
    const Account& a = run.account;
    sum.items += a.items, sum.made += a.made, sum.doubled += a.doubled;
    sum.stray += a.stray, sum.unknown += a.unknown, sum.uncertain += a.uncertain;
    done += run.done, good += run.good(), unasked += !run.was_quiet;
  }
  std::cout << fmt::format("| {} | {} | {} | {} | {} of {} | {} | {} | {} | {} |\n",
                           campaign.machine, campaign.runs, done, unasked, sum.made,
                           sum.items, sum.doubled, sum.stray, sum.unknown, sum.uncertain);
  return good == campaign.runs ? 0 : 1;
}

}  // namespace intaglio::campaign
