// The main of every benchmark: Google Benchmark, and with --markdown the results as
// tables for the documentation. A run's name is TABLE/CASE: one table a TABLE and set of
// counters, a line a case.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

namespace {

/// Three digits that count: 0.964, 16.8, 1234, 3.21 M.
std::string Short(double value) {
  const double size = std::abs(value);
  if (size >= 1e6) return fmt::format("{:.2f} M", value / 1e6);
  if (size >= 1e4) return fmt::format("{:.{}f} k", value / 1e3, size >= 1e5 ? 0 : 1);
  if (size >= 100 || value == std::floor(value)) return fmt::format("{:.0f}", value);
  return fmt::format("{:.{}f}", value, size >= 10 ? 1 : 3);
}

class MarkdownTables : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred) {
        std::cerr << run.benchmark_name() << ": " << run.error_message << "\n";
      } else if (run.run_type == Run::RT_Iteration) {
        Print(run);
      }
    }
  }

 private:
  void Print(const Run& run) {
    const std::string& name = run.run_name.function_name;
    const std::size_t slash = std::min(name.find('/'), name.size());
    std::string which = slash < name.size() ? name.substr(slash + 1) : "";
    if (!run.run_name.args.empty()) which += " " + run.run_name.args;
    const bool by_wall = run.run_name.time_type == "real_time";
    const double total_s = by_wall ? run.real_accumulated_time : run.cpu_accumulated_time;
    std::string heading = "| " + name.substr(0, slash) + " | ms |";
    std::string rule = "|---|---|";
    std::string line = fmt::format(
        "| {} | {} |", which, Short(total_s * 1e3 / static_cast<double>(run.iterations)));
    for (const auto& [counter, value] : run.counters) {
      heading += " " + counter + " |";
      rule += "---|";
      line += " " + Short(value) + " |";
    }
    if (heading != heading_) std::cout << "\n" << heading << "\n" << rule << "\n";
    heading_ = heading;
    std::cout << line << std::endl;
  }

  std::string heading_;
};

}  // namespace

int main(int argc, char** argv) {
  const auto end = std::remove_if(
      argv + 1, argv + argc, [](std::string_view word) { return word == "--markdown"; });
  const bool markdown = end != argv + argc;
  argc = static_cast<int>(end - argv);
  argv[argc] = nullptr;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  MarkdownTables tables;
  benchmark::RunSpecifiedBenchmarks(markdown ? &tables : nullptr);
  benchmark::Shutdown();
  return 0;
}
