#include <CLI/CLI.hpp>
#include <chrono>

#include "services/host/only_instance.h"
#include "services/host/poll_loop.h"
#include "services/job_service/job_service.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

int Serve(host::ServiceHost& host, const job_service::JobServiceOptions& options) {
  const auto now = [] { return std::chrono::steady_clock::now().time_since_epoch(); };
  host::OnlyInstance only(host, intaglio_ROLE_JOB_SERVICE);
  if (only.AwaitTurn()) return only.EndAsSecond("job service");
  job_service::JobService service(host, options, now());
  host::PollLoop loop(host.bus());
  service.AttachTo(loop);
  host.SetHealth(intaglio_HEALTH_READY);
  while (!host.stopping()) {
    if (only.MustEnd()) return only.EndAsSecond("job service");
    service.Turn(now());
    host.KeepAlive();
    loop.Wait({}, 20ms);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  job_service::JobServiceOptions options;
  options.materials = materials_db::DefaultDatabasePath();
  const host::ServiceDescription description{
      intaglio_ROLE_JOB_SERVICE, "job-service",
      "keeps the queue of jobs and hands their stages to workers",
      [&options](CLI::App& app) {
        app.add_option("--database", options.database, "file of the queue")->required();
        app.add_option("--materials-db", options.materials, "material base")
            ->capture_default_str();
        app.add_option("--results", options.results, "folder of the jobs' results")
            ->required();
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
