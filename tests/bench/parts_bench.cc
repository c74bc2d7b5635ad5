// How much faster several discretizers cut a job than one: a shop of real processes, the
// same job with one and with several of them in turn, so that other load of the host
// affects both alike. Client and synchronizer are simulated; before the sorting the job
// is cancelled.
//
//   chrt -f 10 parts_bench JOB [--runs 5] [--discretizers 2] [--most-stolen 2] [--trace]
//
// A virtual machine may lose its processors for a while. A run in which more than
// --most-stolen percent of their time was stolen is repeated.
//
// Each discretizer computes on one thread. A time is from the first task of the
// discretizing to the job's sorting, by the stamps that the writers give their samples:
// the sorter has all points then. --trace prints when each task was given, taken and
// done.

#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "services/job/files/job_file.h"
#include "services/platform/bus/samples.h"
#include "tests/patience.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/services/platform/bus/child_program.h"

namespace intaglio::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using bus::View;
using job_service::TaskCopy;
using test::ChildProgram;
using test::HostTime;

struct Options {
  std::string job;
  std::string programs = INTAGLIO_BIN_DIR;
  int runs = 5;
  int discretizers = 2;
  double max_stolen_percent = 2;
  bool trace = false;
};

/// Processor time of a process so far, of all its threads, s.
double CpuOf(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &used) != 0) {
    return 0;
  }
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

/// The messages on the bus about one job, with the writers' timestamps.
class Watch {
 public:
  explicit Watch(bus::Bus& bus)
      : given_(bus, bus::kDiscretizeTask),
        reported_(bus, bus::kTaskStatus),
        credit_(bus, bus::kCredit),
        jobs_(bus, bus::kJobStatus) {}

  void Begin() {
    Poll();
    events_.clear();
    first_ns_.reset();
    sorting_ns_.reset();
    point_count_ = 0;
  }

  void Poll() {
    given_.TakeAll([this](const intaglio_StageTask& task, const bus::SampleOrigin& from) {
      if (!from.alive) return;
      if (!first_ns_ && !task.revoked) first_ns_ = from.source_ns;
      Note(from,
           fmt::format("{} {}.{} of {} {} {}", View(task.job_uid), task.part,
                       task.part_attempt, task.part_count,
                       task.revoked ? "revoked from" : "given to", View(task.worker)));
    });
    reported_.TakeAll(
        [this](const intaglio_TaskStatus& task, const bus::SampleOrigin& from) {
          if (!from.alive || task.stage != intaglio_STAGE_DISCRETIZE) return;
          constexpr const char* kStates[] = {"accepted", "running", "paused", "done",
                                             "failed"};
          Note(from, fmt::format("{} {}.{} {} {} of {} {}", View(task.job_uid), task.part,
                                 task.part_attempt, kStates[task.state], task.done_count,
                                 task.total_count, View(task.message)));
          if (task.state == intaglio_TASK_DONE) point_count_ += task.done_count;
        });
    credit_.TakeAll([this](const intaglio_Credit& credit, const bus::SampleOrigin& from) {
      if (!from.alive || (credit.consumed == 0 && first_ns_)) return;
      Note(from, fmt::format("credit {} {}", View(credit.stream), credit.consumed));
    });
    jobs_.TakeAll([this](const intaglio_JobStatus& job, const bus::SampleOrigin& from) {
      if (!from.alive || job.state != intaglio_JOB_SORTING || sorting_ns_) return;
      sorting_ns_ = from.source_ns;
      Note(from, "sorting");
    });
  }

  bool sorting() const { return sorting_ns_.has_value(); }
  double seconds() const {
    return 1e-9 * static_cast<double>(sorting_ns_.value() - first_ns_.value());
  }
  std::uint64_t point_count() const { return point_count_; }
  void Print() {
    std::sort(events_.begin(), events_.end());
    for (const auto& [at_ns, text] : events_) {
      const double at_ms = 1e-6 * static_cast<double>(at_ns - first_ns_.value());
      if (at_ms >= 0) fmt::print("{:9.2f} ms  {}\n", at_ms, text);
    }
  }

 private:
  void Note(const bus::SampleOrigin& from, std::string text) {
    events_.emplace_back(from.source_ns, std::move(text));
  }

  bus::Reader<intaglio_StageTask> given_;
  bus::Reader<intaglio_TaskStatus> reported_;
  bus::Reader<intaglio_Credit> credit_;
  bus::Reader<intaglio_JobStatus> jobs_;
  std::vector<std::pair<std::int64_t, std::string>> events_;
  std::optional<std::int64_t> first_ns_, sorting_ns_;
  std::uint64_t point_count_ = 0;
};

struct Measured {
  double seconds = 0;
  double stolen_percent = 0;
  std::uint64_t point_count = 0;
  std::map<std::string, double> cpu_s;  // by program
};

class Shop {
 public:
  Shop(const Options& options, fs::path folder)
      : options_(options),
        folder_(std::move(folder)),
        job_(ReadJobFile(options.job).value()),
        service_(Start("intaglio-job-service",
                       {"--database", folder_ / "jobs.db", "--materials-db",
                        folder_ / "materials.db", "--results", folder_ / "results"})),
        sorter_(Start("intaglio-sorter", {})) {}

  /// The first run of a few with little enough stolen time.
  Measured Run(int discretizers) {
    constexpr int kTries = 20;
    for (int again = 0; again < kTries; ++again) {
      const Measured measured = RunOnce(discretizers);
      if (measured.stolen_percent <= options_.max_stolen_percent) return measured;
      fmt::print("with {}: {:.3f} s, {:.0f} % stolen\n", discretizers, measured.seconds,
                 measured.stolen_percent);
      std::fflush(stdout);
    }
    throw std::runtime_error("the host never had its processors to itself");
  }

 private:
  Measured RunOnce(int discretizers) {
    std::vector<std::unique_ptr<ChildProgram>> workers;
    for (int i = 0; i < discretizers; ++i) {
      workers.push_back(Start("intaglio-discretizer", {"--threads", "1"}));
    }
    for (const auto& worker : workers) AwaitReady(worker->pid());
    AwaitReady(sorter_->pid());
    std::this_thread::sleep_for(500ms);  // until all have found one another
    watch_.Begin();
    const std::string submission = fmt::format("run {}", ++run_);
    const double service = CpuOf(service_->pid()), sorter = CpuOf(sorter_->pid());
    std::vector<double> before;
    for (const auto& worker : workers) before.push_back(CpuOf(worker->pid()));
    const HostTime host = HostTime::Now();
    shop_.Submit(submission, job_);
    Until([&] { return watch_.sorting(); }, submission);
    Measured measured{watch_.seconds(),
                      HostTime::Now().StolenPercentSince(host),
                      watch_.point_count(),
                      {}};
    measured.cpu_s["job-service"] = CpuOf(service_->pid()) - service;
    measured.cpu_s["sorter"] = CpuOf(sorter_->pid()) - sorter;
    for (std::size_t i = 0; i < workers.size(); ++i) {
      measured.cpu_s["discretizers"] += CpuOf(workers[i]->pid()) - before[i];
    }
    if (options_.trace) watch_.Print();
    Cancel(submission);
    for (const auto& worker : workers) {
      worker->Signal(SIGTERM);
      (void)worker->ExitCode();
    }
    return measured;
  }
  std::unique_ptr<ChildProgram> Start(const std::string& program,
                                      std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--tag", test::PrivateTag(), "--die-with-parent",
                                       "--log-level", "error"});
    return std::make_unique<ChildProgram>(options_.programs + "/" + program, arguments);
  }

  /// The synchronizer's health and its answers go on meanwhile.
  void Until(const std::function<bool()>& condition, const std::string& submission = {}) {
    const auto end = std::chrono::steady_clock::now() + 120s;
    auto next = std::chrono::steady_clock::now();
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) {
        throw std::runtime_error("the shop does not come on: " +
                                 shop_.Status(submission).message);
      }
      if (std::chrono::steady_clock::now() >= next) {
        next += 200ms;
        Synchronize(submission);
      }
      watch_.Poll();
      TakeHealth();
      std::this_thread::sleep_for(5ms);
    }
  }
  void Synchronize(const std::string& submission) {
    const TaskCopy task = shop_.Task(intaglio_STAGE_ENGRAVE);
    const bool at_work = !submission.empty() && !task.revoked &&
                         task.job_uid == shop_.Status(submission).uid &&
                         !task.job_uid.empty();
    shop_.Health(intaglio_STAGE_ENGRAVE, "y",
                 at_work ? intaglio_HEALTH_BUSY : intaglio_HEALTH_READY);
    if (at_work) shop_.Report(task, intaglio_STAGE_ENGRAVE, intaglio_TASK_ACCEPTED, 0, 0);
  }
  void TakeHealth() {
    health_.Take([this](const intaglio_ServiceHealth& sample) {
      state_of_[sample.pid] = sample.state;
    });
  }
  void AwaitReady(pid_t process) {
    Until([&] {
      const auto found = state_of_.find(process);
      return found != state_of_.end() && found->second == intaglio_HEALTH_READY;
    });
  }
  void Cancel(const std::string& submission) {
    state_of_.clear();
    shop_.Command(shop_.Status(submission), intaglio_COMMAND_CANCEL, 1, false,
                  submission);
    Until([&] { return shop_.Status(submission).state == intaglio_JOB_CANCELLED; },
          submission);
    shop_.Report(shop_.Task(intaglio_STAGE_ENGRAVE), intaglio_STAGE_ENGRAVE,
                 intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_CANCELLED, "");
    AwaitReady(sorter_->pid());
  }

  const Options& options_;
  fs::path folder_;
  JobSpec job_;
  bus::Bus bus_{test::PrivateBusOptions()};
  job_service::FakeShop shop_{test::PrivateBusOptions()};
  bus::Reader<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  Watch watch_{bus_};
  std::unique_ptr<ChildProgram> service_, sorter_;
  std::map<pid_t, intaglio_HealthState> state_of_;
  int run_ = 0;
};

void Print(const char* name, const std::vector<Measured>& all) {
  std::vector<double> seconds;
  std::string values;
  for (const Measured& one : all) {
    seconds.push_back(one.seconds);
    values += fmt::format("{}{:.3f}", values.empty() ? "" : ", ", one.seconds);
  }
  fmt::print("{}: {} points, median {:.3f} s ({})\n", name, all.front().point_count,
             Median(seconds), values);
  for (const auto& [program, unused] : all.front().cpu_s) {
    std::vector<double> cpu_s;
    for (const Measured& one : all) cpu_s.push_back(one.cpu_s.at(program));
    fmt::print("  processor, {}: {:.3f} s\n", program, Median(cpu_s));
  }
}

int Main(const Options& options) {
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("parts_bench-{}", getpid());
  std::vector<Measured> one, several;
  {
    Shop shop(options, folder);
    for (int run = 0; run < options.runs; ++run) {
      one.push_back(shop.Run(1));
      several.push_back(shop.Run(options.discretizers));
    }
  }
  fs::remove_all(folder);
  Print("one discretizer", one);
  Print(fmt::format("{} discretizers", options.discretizers).c_str(), several);
  std::vector<double> of_one, of_several;
  for (const Measured& run : one) of_one.push_back(run.seconds);
  for (const Measured& run : several) of_several.push_back(run.seconds);
  fmt::print("ratio of the medians {:.2f}\n", Median(of_one) / Median(of_several));
  return 0;
}

}  // namespace
}  // namespace intaglio::bench

int main(int argc, char** argv) {
  intaglio::bench::Options options;
  CLI::App app("Several discretizers beside one");
  app.add_option("job", options.job, "job file")->required()->check(CLI::ExistingFile);
  app.add_option("--programs", options.programs, "folder of the programs")
      ->capture_default_str();
  app.add_option("--runs", options.runs, "of each")->capture_default_str();
  app.add_option("--discretizers", options.discretizers, "how many are several")
      ->capture_default_str();
  app.add_option("--most-stolen", options.max_stolen_percent,
                 "percent of the processors' time that may be taken away in a run")
      ->capture_default_str();
  app.add_flag("--trace", options.trace, "tell what was said when");
  CLI11_PARSE(app, argc, argv);
  try {
    return intaglio::bench::Main(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
