#include <unistd.h>

#include <iostream>
#include <thread>

#include "engrave/core/counted.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/version/software_version.h"
#include "services/recorder/job_attachments.h"
#include "services/recorder/recorder.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

struct Options {
  std::string file;
  double split_mb = 0, split_min = 0, keep_mb = 0, keep_h = 0, queue_mb = 64;
  int compression = 1;
  std::string bulk = recording::NameOf(recording::Bulk::kAll);
  bool scene = false;
  bus::TopicFilter filter;
};

void AddOptions(command_line::Command app, Options& options) {
  app.AddOption("--out", options.file,
                "file to write; if it exists, NAME-0002.mcap and so on")
      .Require();
  const auto names = [&app](const std::string& what, bus::NameFilter& filter) {
    app.AddOption("--" + what, filter.only,
                  "record these only; a " + what + ", or a pattern with * and ?");
    app.AddOption("--not-" + what, filter.not_, "record all but these");
  };
  names("topic", options.filter.topic);
  names("partition", options.filter.partition);
  names("type", options.filter.type);
  const auto amount = [&app](const char* flag, double& value, const char* what) {
    app.AddOption(flag, value, what).Within(0.0, 1e9).ShowDefault();
  };
  amount("--split-mb", options.split_mb, "begin a new file at this size, MB; 0: never");
  amount("--split-min", options.split_min, "or after this time, minutes; 0: never");
  amount("--keep-mb", options.keep_mb,
         "remove the oldest files beyond this size together, MB; 0: keep all");
  amount("--keep-h", options.keep_h,
         "remove files not written for this many hours; 0: keep all");
  amount("--queue-mb", options.queue_mb,
         "memory for messages that wait for the disk, MB; beyond it bulk is left out");
  app.AddFlag("--scene", options.scene,
              "also the jobs as a scene for Foxglove, Lichtblick and Rerun");
  app.AddOption(
         "--bulk", options.bulk,
         "what grows with the points of a job (models, points, motion, positions): "
         "all of it, thin (one message in ten, no models), or none")
      .OneOf({"all", "thin", "none"})
      .ShowDefault();
  app.AddOption("--compression", options.compression, "level of zstd; 0: none")
      .Within(0, 19)
      .ShowDefault();
}

recorder::RecorderOptions RecorderOptionsOf(const Options& options) {
  constexpr double kMb = 1e6, kMinuteNs = 60e9, kHourNs = 3600e9;
  recorder::RecorderOptions made;
  made.filter = options.filter;
  made.bulk = *recording::BulkFromName(options.bulk);  // one of the choices
  made.scene = options.scene;
  made.queue.large_bytes = static_cast<std::uint64_t>(options.queue_mb * kMb);
  made.queue.total_bytes = 4 * made.queue.large_bytes;
  recorder::SeriesOptions& series = made.series;
  series.file = options.file;
  series.split_bytes = static_cast<std::uint64_t>(options.split_mb * kMb);
  series.split_ns = static_cast<std::uint64_t>(options.split_min * kMinuteNs);
  series.keep_bytes = static_cast<std::uint64_t>(options.keep_mb * kMb);
  series.keep_ns = static_cast<std::uint64_t>(options.keep_h * kHourNs);
  series.version = host::SoftwareVersion();
  char host_name[256] = "localhost";
  gethostname(host_name, sizeof host_name - 1);
  series.host = host_name;
  series.writer.compress = options.compression > 0;
  series.writer.compression_level = std::max(1, options.compression);
  // Half of the data that may be lost, so that the other half is left for delays of a
  // busy host.
  series.writer.chunk_ns = 500'000'000;
  return made;
}

/// Reports troubles once, when they begin.
void Report(host::ServiceHost& host, const recorder::Recorder::State& state,
            bool& in_trouble) {
  if (state.trouble) {
    host.SetHealth(intaglio_HEALTH_FAULT, {}, state.trouble->message);
    if (!in_trouble) {
      host.RaiseAlarm(intaglio_ALARM_WARNING, ErrorCodeName(state.trouble->code),
                      state.trouble->message);
    }
  } else {
    host.SetHealth(intaglio_HEALTH_READY);
  }
  in_trouble = state.trouble.has_value();
}

/// A disk that is full, or refuses otherwise, is waited for: the shop goes on meanwhile,
/// and is recorded as soon as there is room. A missing folder is not waited for.
Result<std::unique_ptr<recorder::Recorder>> StartPatiently(host::ServiceHost& host,
                                                           const Options& options) {
  bool in_trouble = false;
  for (;;) {
    auto recorder = recorder::Recorder::Start(host.bus(), RecorderOptionsOf(options));
    if (recorder || recorder.error().code != ErrorCode::kIo) return recorder;
    recorder::Recorder::State state;
    state.trouble = recorder.error();
    Report(host, state, in_trouble);
    for (int i = 0; i < 10; ++i) {
      if (host.stopping()) return recorder;
      host.KeepAlive();
      std::this_thread::sleep_for(100ms);
    }
  }
}

int Serve(host::ServiceHost& host, const Options& options) {
  auto recorder = StartPatiently(host, options);
  if (!recorder) {
    std::cerr << recorder.error().message << "\n";
    return recorder.error().code == ErrorCode::kIo ? 1 : 2;
  }
  std::cerr << "records into " << (*recorder)->state().file << "\n";
  recorder::JobAttachments attachments(host.bus());
  bool in_trouble = false;
  while (!host.stopping()) {
    (*recorder)->Turn(100ms);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    for (auto& attachment : attachments.Take(static_cast<std::uint64_t>(now / 1ns))) {
      (*recorder)->Attach(std::move(attachment));
    }
    Report(host, (*recorder)->state(), in_trouble);
    host.KeepAlive();
  }
  host.SetHealth(intaglio_HEALTH_STOPPING);
  const auto stopped = (*recorder)->Stop();
  const auto state = (*recorder)->state();
  std::cerr << Counted(state.message_count, "message") << " in " << state.file;
  if (state.missing_count > 0) std::cerr << ", " << state.missing_count << " missing";
  if (state.message_count == 0) {
    std::cerr << ": nothing was received; check that a shop is open at this --domain, "
                 "--interface and --tag, and has the topics that were chosen";
  }
  std::cerr << "\n";
  if (stopped) return 0;
  std::cerr << stopped.error().message << "\n";
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const host::ServiceDescription description{
      intaglio_ROLE_RECORDER, "recorder", "records every topic into an MCAP file",
      [&options](command_line::Command app) { AddOptions(app, options); }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
