// The cost of recording for the pipeline: `intaglio run` of one job with and without it,
// in turn, so that other load of the host affects both alike.
//
//   recording_bench [RUNS [JOB]]     default 5 of deploy/jobs/sample.textproto, lockstep

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// Seconds of the whole command, or less than 0 when it failed.
double Run(const std::string& job, const fs::path& out, const char* recording) {
  std::vector<std::string> words = {INTAGLIO_BIN_DIR "/intaglio",
                                    "run",
                                    job,
                                    "--lockstep",
                                    "--out",
                                    out.string(),
                                    recording};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", 1 /* O_WRONLY */, 0);
  }
  const auto begin = std::chrono::steady_clock::now();
  pid_t process = -1;
  int status = -1;
  if (posix_spawn(&process, argv[0], &quiet, nullptr, argv.data(), environ) == 0) {
    waitpid(process, &status, 0);
  }
  posix_spawn_file_actions_destroy(&quiet);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  return status == 0 ? took.count() : -1;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 5;
  const std::string job =
      argc > 2 ? argv[2] : INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto";
  const fs::path out =
      fs::temp_directory_path() / fmt::format("recording_bench-{}", getpid());
  std::vector<double> with, without;
  std::uintmax_t bytes = 0;
  for (int i = 0; i < runs; ++i) {
    without.push_back(Run(job, out / "without", "--no-record"));
    with.push_back(Run(job, out / "with", "--record"));
    if (without.back() < 0 || with.back() < 0) {
      fmt::print(stderr, "a run failed; see {}\n", out.string());
      return 1;
    }
    bytes = fs::file_size(out / "with" / "session.mcap");
  }
  fmt::print("| | median of {} runs |\n|---|---|\n", runs);
  fmt::print("| without recording | {:.2f} s |\n", Median(without));
  fmt::print("| with recording | {:.2f} s |\n", Median(with));
  fmt::print("| ratio | {:.3f} |\n", Median(with) / Median(without));
  fmt::print("| session.mcap | {:.1f} MB |\n", static_cast<double>(bytes) * 1e-6);
  fs::remove_all(out);
  return 0;
}
