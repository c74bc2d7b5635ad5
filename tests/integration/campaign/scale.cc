#include "tests/integration/campaign/scale.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <thread>

#include "services/platform/bus/bus.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::campaign {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::Ended;
using testing::Program;
using testing::Running;

constexpr int kDomain = 48;
constexpr auto kSettles = 5s, kMeasured = 10s, kRetained = 2s;
constexpr int kRepetitions = 5;

double Seconds(Clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

/// The value at this share of all; 0 of none.
double Quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto place =
      static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

/// Processor time of a process so far, s.
double ProcessorSeconds(pid_t process) {
  std::ifstream in(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(in, line);
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  constexpr int kUserTime = 12;  // the fields behind the name count from 1
  std::string skipped;
  for (int i = 1; i < kUserTime; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double ProportionalMegabytes(pid_t process) {
  std::ifstream in(fmt::format("/proc/{}/smaps_rollup", process));
  for (std::string word; in >> word;) {
    double kb = 0;
    if (word == "Pss:" && in >> kb) return kb / 1024;
  }
  return 0;
}

std::size_t ThreadCount(pid_t process) {
  std::error_code error;
  const fs::directory_iterator tasks(fmt::format("/proc/{}/task", process), error);
  return error ? 0 : static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

/// Packets that the loopback interface has received so far.
double LoopbackPackets() {
  std::ifstream in("/proc/net/dev");
  for (std::string word; in >> word;) {
    double bytes = 0, packets = 0;
    if (word == "lo:" && in >> bytes >> packets) return packets;
  }
  return 0;
}

struct Ages {
  std::vector<double> interlocks_ms, motion_ms;
};

/// What a client receives that follows all cells. What was retained for it is older than
/// the client, and is left out.
Ages MeasureAges(const std::string& tag) {
  bus::BusOptions options;
  options.control_domain = kDomain;
  options.tag = tag;
  bus::Bus bus(options);
  bus::Reader<intaglio_Interlock> interlocks(bus, bus::kInterlock);
  bus::Reader<intaglio_MotionState> motion(bus, bus::kMotionState);
  bus::WaitSet wait(bus);
  wait.Attach(interlocks);
  wait.Attach(motion);
  Ages ages;
  const auto begin = Clock::now() + kRetained, end = begin + kMeasured;
  const auto take = [&](auto& reader, std::vector<double>& into) {
    reader.TakeAll([&](const auto&, const bus::SampleOrigin& origin) {
      const std::chrono::nanoseconds now =
          std::chrono::system_clock::now().time_since_epoch();
      if (origin.alive && Clock::now() >= begin)
        into.push_back(1e-6 * static_cast<double>(now.count() - origin.source_ns));
    });
  };
  while (Clock::now() < end) {
    wait.Wait(50ms);
    take(interlocks, ages.interlocks_ms);
    take(motion, ages.motion_ms);
  }
  return ages;
}

class IdleShop {
 public:
  explicit IdleShop(int cells)
      : cells_(cells),
        tag_(fmt::format("scale-{}-{}", getpid(), cells)),
        folder_(test::FreshFolder(tag_)) {
    up_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--cells", std::to_string(cells), "--virtual", "--folder",
              folder_ / "shop", "--materials", folder_ / "materials.db"}),
        folder_ / "up.txt");
  }
  ~IdleShop() { Close(); }

  bool AwaitOpen() {
    constexpr auto kBound = 120s;
    return testing::Eventually([this] { return !up_->running() || IsOpen(); }, kBound) &&
           up_->running();
  }
  /// Nothing is left of it.
  bool Close() {
    up_->Signal(SIGTERM);
    constexpr auto kBound = 60s;
    const bool ended = up_->WaitForEnd(kBound).exit_code == 0;
    return ended && Processes().empty();
  }

  std::vector<pid_t> Processes() const { return testing::ProcessesWith({tag_}); }
  /// A command of `intaglio` in this shop, to its end.
  Ended Type(const std::vector<std::string>& words) const {
    constexpr auto kBound = 60s;
    Running typed(Program("intaglio"), With(words), folder_ / "typed.txt");
    return typed.WaitForEnd(kBound);
  }
  double MedianSeconds(const std::vector<std::string>& words) const {
    std::vector<double> seconds;
    for (int i = 0; i < kRepetitions; ++i) seconds.push_back(Type(words).seconds);
    return Quantile(seconds, 0.5);
  }
  bool FindsAll() const {
    const std::string status = Type({"status"}).output;
    int machines = 0;
    std::istringstream lines(status);
    for (std::string line; std::getline(lines, line);)
      machines += line.starts_with("machine ") ? 1 : 0;
    if (machines != cells_) std::cerr << status << Output();
    return machines == cells_;
  }
  std::string Output() const { return up_->Output(); }
  const std::string& tag() const { return tag_; }

 private:
  bool IsOpen() const { return Output().find("the shop is open") != std::string::npos; }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", std::to_string(kDomain), "--tag", tag_});
    return words;
  }

  int cells_;
  std::string tag_;
  fs::path folder_;
  std::unique_ptr<Running> up_;
};

/// The cost of the processes at rest: "processes | threads | PSS | cores | packets a
/// second".
std::string CostAtRest(const IdleShop& shop) {
  std::this_thread::sleep_for(kSettles);
  const std::vector<pid_t> processes = shop.Processes();
  const auto processor_time = [&processes] {
    double sum = 0;
    for (const pid_t process : processes) sum += ProcessorSeconds(process);
    return sum;
  };
  const auto began = Clock::now();
  const double time_before = processor_time(), packets_before = LoopbackPackets();
  std::this_thread::sleep_for(kMeasured);
  const double took = Seconds(Clock::now() - began);
  const double packets = (LoopbackPackets() - packets_before) / took;
  const double cores = (processor_time() - time_before) / took;
  std::size_t threads = 0;
  double memory_mb = 0;
  for (const pid_t process : processes) {
    threads += ThreadCount(process);
    memory_mb += ProportionalMegabytes(process);
  }
  return fmt::format("{} | {} | {:.0f} | {:.2f} | {:.0f}", processes.size(), threads,
                     memory_mb, cores, packets);
}

/// The ages while millions of points go from the discretizer to the sorter, which takes
/// longer than the measurement. `job`: is open, and has the machine.
Ages AgesWithBulk(const IdleShop& shop, const std::string& job) {
  shop.Type({"cancel", job});
  const Ended given =
      shop.Type({"submit", INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto",
                 "--height", "24", "--spacing", "0.02"});
  if (given.exit_code != 0) std::cerr << given.output;
  return MeasureAges(shop.tag());
}

bool AddRow(int cells) {
  const auto began = Clock::now();
  IdleShop shop(cells);
  if (!shop.AwaitOpen()) {
    std::cerr << shop.Output();
    return false;
  }
  const double found_s = Seconds(Clock::now() - began);
  const std::string cost = CostAtRest(shop);
  Ages ages = MeasureAges(shop.tag());
  const bool finds_all = shop.FindsAll();
  // Unarmed: it is shown, and its machine stays at rest.
  shop.Type(
      {"submit", INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto", "--height", "6"});
  const auto age = [](std::vector<double>& ms) {
    return fmt::format("{:.2f} / {:.1f}", Quantile(ms, 0.5), Quantile(ms, 0.99));
  };
  const double list_s = shop.MedianSeconds({"list"});
  const double show_s = shop.MedianSeconds({"show", "1"});
  const double status_s = shop.MedianSeconds({"status"});
  Ages with_bulk = AgesWithBulk(shop, "1");
  std::cout << fmt::format("| {} | {} | {:.1f} | {} | {} | {} | {} | ", cells, cost,
                           found_s, age(ages.interlocks_ms), age(ages.motion_ms),
                           age(with_bulk.interlocks_ms), age(with_bulk.motion_ms))
            << fmt::format("{:.2f} | {:.2f} | {:.2f} |\n", list_s, show_s, status_s)
            << std::flush;
  return shop.Close() && finds_all;
}

}  // namespace

int RunScale(const std::vector<std::string>& counts) {
  std::vector<int> cells;
  for (const std::string& count : counts) cells.push_back(std::atoi(count.c_str()));
  if (cells.empty()) cells = {1, 3, 10};
  const auto is_wrong = [](int count) { return count < 1 || count > 100; };
  if (std::any_of(cells.begin(), cells.end(), is_wrong)) return 2;
  std::cout << "| cells | processes | threads | PSS, MB | cores | packets/s | all found "
               "after, s | age of interlocks, ms (p50 / p99) | of the state of stages | "
               "of interlocks with a bulk transfer | of stages with it | `list`, s | "
               "`show` | `status` |\n"
               "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  bool good = true;
  for (const int count : cells) good = AddRow(count) && good;
  return good ? 0 : 1;
}

}  // namespace intaglio::campaign
