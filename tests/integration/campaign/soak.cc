#include "tests/integration/campaign/soak.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/campaign/cell_under_fire.h"
#include "tests/test_folder.h"

namespace intaglio::campaign {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kBound = 90s;  // of a job
constexpr int kMinJobs = 6, kMaxBadJobs = 3;

/// What a process holds of the machine it runs on.
struct Holdings {
  long memory_kb = 0, threads = 0, descriptors = 0;
};

Holdings HoldingsOf(pid_t process) {
  Holdings holds;
  const std::string folder = fmt::format("/proc/{}", process);
  std::ifstream status(folder + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) holds.memory_kb = std::atol(line.c_str() + 6);
    if (line.starts_with("Threads:")) holds.threads = std::atol(line.c_str() + 8);
  }
  std::error_code error;
  const fs::directory_iterator descriptors(folder + "/fd", error), end;
  holds.descriptors = std::distance(descriptors, end);
  return holds;
}

/// Files below the folder that belong to no job. Some go away while they are counted.
long FilesBesideJobs(const fs::path& folder) {
  long files = 0;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error), end;
  for (; !error && at != end; at.increment(error)) {
    if (at->path() == folder / "shop/jobs") at.disable_recursion_pending();
    files += at->is_regular_file(error) ? 1 : 0;
    error.clear();
  }
  return files;
}

/// The most of each service at any time: the bus's receive buffers come and go, 2 MB
/// each.
struct Peaks {
  std::map<std::string, Holdings> services;
  long files = 0;
};

void Read(const CellUnderFire& cell, Peaks& peaks) {
  for (const char* service :
       {"intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
        "intaglio-synchronizer", "intaglio-motion-bridge"}) {
    const Holdings now = HoldingsOf(cell.ProcessOf(service));
    Holdings& peak = peaks.services[service];
    peak.memory_kb = std::max(peak.memory_kb, now.memory_kb);
    peak.threads = std::max(peak.threads, now.threads);
    peak.descriptors = std::max(peak.descriptors, now.descriptors);
  }
  peaks.files = std::max(peaks.files, FilesBesideJobs(cell.folder()));
}

/// Something that happens to a job in a shop, and is set right again.
void Disturb(CellUnderFire& cell, std::mt19937& random) {
  static const std::vector<std::pair<std::string, std::string>> kDisturbances = {
      {"drop-bytes 0.001 laser", "drop-bytes 0 laser"},
      {"drop-bytes 0.001 motion", "drop-bytes 0 motion"},
      {"unplug laser", "plug laser"},
      {"unplug motion", "plug motion"},
      {"door force", "door close"},
      {"estop press", "estop release"}};
  const auto& [wrong, right] = kDisturbances[random() % kDisturbances.size()];
  cell.AwaitCracks(cell.Cracks() + random() % 200, 5s);
  cell.Press(wrong);
  usleep(random() % 500'000);
  cell.Press(right);
}

/// Whether something grew.
bool PrintHoldings(Peaks before, const Peaks& now) {
  bool grew = now.files > before.files;
  for (const auto& [service, after] : now.services) {
    const Holdings& first = before.services[service];
    std::cout << fmt::format("| {} | {} -> {} | {} -> {} | {} -> {} |\n", service,
                             first.memory_kb, after.memory_kb, first.threads,
                             after.threads, first.descriptors, after.descriptors);
    // A thread or a descriptor more is one that was not given back; of memory an
    // allocator keeps a little in reserve.
    constexpr long kReserveKb = 2048;
    grew = grew || after.threads > first.threads ||
           after.descriptors > first.descriptors ||
           after.memory_kb > first.memory_kb + kReserveKb;
  }
  std::cout << fmt::format("files of no job: {} -> {}\n", before.files, now.files);
  return grew;
}

}  // namespace

int RunSoak(const SoakOptions& options) {
  std::mt19937 random(options.seed);
  const auto folder = test::FreshFolder(fmt::format("soak-{}", getpid()));
  CellUnderFire cell(folder, fmt::format("soak-{}", getpid()), "lockstep");
  if (!cell.OpenShop()) return 1;
  double hours = 0;
  int jobs = 0, bad = 0;
  std::size_t points = 0, made = 0;
  std::uint64_t first_tick = 0, last_tick = 0;
  // In the first third lists, arenas and the bus's books fill up.
  Peaks middle, last;
  for (; (hours < options.hours || jobs < kMinJobs) && bad < kMaxBadJobs; ++jobs) {
    // At 1 Hz a tick is a second of the machine.
    bool done = cell.Submit("1");
    Disturb(cell, random);
    done = done && cell.AwaitDoneResuming(kBound);
    const Verdict v = cell.Judge();
    const bool in_time = v.mistimed == 0 && v.first_tick > last_tick;
    if (!done || !v.good() || !in_time) {
      ++bad;
      std::cerr << fmt::format(
          "job {}: {} of {} made, {} doubled, {} stray, {} unknown, {} uncertain, {} at "
          "another tick; ticks {} to {} after {}; {} {}\n",
          jobs + 1, v.made, v.points, v.doubled, v.stray, v.unknown, v.uncertain,
          v.mistimed, v.first_tick, v.last_tick, last_tick, v.trouble,
          done ? "" : cell.Show());
    }
    points += v.points, made += v.made;
    if (jobs == 0) first_tick = v.first_tick;
    last_tick = v.last_tick;
    // A point a second; what passed at rest is no work.
    hours += static_cast<double>(v.made) / 3600;
    if (hours >= options.hours / 3) {
      Read(cell, hours < 2 * options.hours / 3 ? middle : last);
    }
  }
  std::cout << fmt::format(
      "{} jobs, {:.1f} hours of engraving at 1 Hz, {} of {} points made, {} bad, {} "
      "ticks\n| service | memory, kB | threads | descriptors |\n",
      jobs, hours, made, points, bad, last_tick - first_tick + 1);
  const bool grew = PrintHoldings(middle, last);
  return bad > 0 || grew ? 1 : 0;
}

}  // namespace intaglio::campaign
