#include <chrono>
#include <thread>

#include "materials_db/material_store.h"
#include "services/job_service/boot_clock.h"
#include "services/job_service/disk_report.h"
#include "services/job_service/job_service.h"
#include "services/job_service/status_board.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/poll_loop.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

/// What stays on the bus from one life of the queue to the next.
struct Published {
  Published(host::ServiceHost& host, const job_service::JobServiceOptions& options)
      : board(host.bus(), host.instance()),
        disk(host.bus(), host.instance(),
             {std::filesystem::absolute(options.database).parent_path(),
              options.results}) {}
  job_service::StatusBoard board;
  job_service::DiskReport disk;
};

/// One life of the queue; `opened` once it is there.
int ServeQueue(host::ServiceHost& host, const job_service::JobServiceOptions& options,
               Published& published, host::OnlyInstance& only, bool& opened) {
  job_service::JobService service(host, options, published.board,
                                  job_service::SinceBoot());
  host::PollLoop loop(host.bus());
  service.AttachTo(loop);
  host.SetHealth(intaglio_HEALTH_READY);
  opened = true;
  try {
    while (!host.stopping()) {
      if (only.MustEnd()) return only.EndAsSecond("job service");
      service.Turn(job_service::SinceBoot());
      host.KeepAlive();
      published.disk.Turn(job_service::SinceBoot());
      loop.Wait({}, 20ms);
    }
    service.Close(job_service::SinceBoot());
  } catch (const job_service::StoreError& error) {
    service.PublishFault(error.what());
    throw;
  }
  return 0;
}

// Nothing may follow from a change that is not stored. With a disk that is full the queue
// is given up, and every permission with it; it is read again as soon as it can be
// written. A disk that is full at the start is waited for in the same way; a file that is
// no database of this program's ends it.
int Serve(host::ServiceHost& host, const job_service::JobServiceOptions& options) {
  host::OnlyInstance only(host, intaglio_ROLE_JOB_SERVICE);
  if (only.AwaitTurn()) return only.EndAsSecond("job service");
  Published published(host, options);
  bool opened = false;
  std::string raised;
  while (!host.stopping()) {
    try {
      return ServeQueue(host, options, published, only, opened);
    } catch (const job_service::StoreError& error) {
      if (!opened && !error.passes()) throw;
      host.SetHealth(intaglio_HEALTH_FAULT, {}, error.what());
      if (raised != error.what()) {
        host.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kIo),
                        error.what());
      }
      raised = error.what();
    }
    for (const auto end = job_service::SinceBoot() + 1s;
         job_service::SinceBoot() < end && !host.stopping();) {
      host.KeepAlive();
      published.disk.Turn(job_service::SinceBoot());
      std::this_thread::sleep_for(50ms);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  job_service::JobServiceOptions options;
  options.materials = materials_db::DefaultDatabasePath();
  const host::ServiceDescription description{
      intaglio_ROLE_JOB_SERVICE, "job-service",
      "keeps the queue of jobs and assigns their stages to workers",
      [&options](command_line::Command app) {
        app.AddOption("--database", options.database, "file of the queue").Require();
        app.AddOption("--materials-db", options.materials, "material base").ShowDefault();
        app.AddOption("--results", options.results, "folder of the jobs' results")
            .Require();
        app.AddOption("--recording", options.recording,
                      "recording of the shop, for the history");
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
