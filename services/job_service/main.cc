#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "materials_db/material_store.h"
#include "services/job_service/boot_clock.h"
#include "services/job_service/job_service.h"
#include "services/job_service/published/disk_report.h"
#include "services/job_service/published/service_list.h"
#include "services/job_service/published/status_board.h"
#include "services/job_service/store_turn.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/poll_loop.h"
#include "services/sql/address.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

std::vector<std::filesystem::path> FoldersOf(
    const job_service::JobServiceOptions& options) {
  if (sql::IsServerAddress(options.database)) return {options.results};
  return {std::filesystem::absolute(options.database).parent_path(), options.results};
}

/// What stays on the bus from one life of the queue to the next.
struct Published {
  Published(host::ServiceHost& host, const job_service::JobServiceOptions& options)
      : board(host.bus(), host.instance()),
        disk(host.bus(), host.instance(), FoldersOf(options)),
        services(host.bus(), host.instance()) {}
  void Turn() {
    disk.Turn(job_service::SinceBoot());
    services.Turn(job_service::SinceBoot());
  }

  job_service::StatusBoard board;
  job_service::DiskReport disk;
  job_service::ServiceList services;
};

/// A job service from the process's start to its end.
class Server {
 public:
  Server(host::ServiceHost& host, const job_service::JobServiceOptions& options)
      : host_(host), options_(options), turn_(options.database, options.standby) {}

  int Serve();

 private:
  /// False: another job service is at work on this bus.
  bool Begin();
  /// The store, or nothing when this process is to end meanwhile.
  std::optional<job_service::JobStore> AwaitStore();
  /// One life of the queue.
  int ServeQueue(job_service::JobStore store);
  void Report(const job_service::StoreError& error);
  void Pause(std::chrono::milliseconds time);

  host::ServiceHost& host_;
  const job_service::JobServiceOptions& options_;
  job_service::StoreTurn turn_;
  std::optional<host::OnlyInstance> only_;
  std::optional<Published> published_;
  bool opened_ = false;
  std::string raised_;
};

bool Server::Begin() {
  using Starting = host::OnlyInstance::Starting;
  only_.emplace(host_, intaglio_ROLE_JOB_SERVICE,
                options_.standby ? Starting::kWaits : Starting::kIsRival);
  if (only_->AwaitTurn()) return false;
  published_.emplace(host_, options_);
  return true;
}

void Server::Pause(std::chrono::milliseconds time) {
  const auto end = job_service::SinceBoot() + time;
  while (job_service::SinceBoot() < end && !host_.stopping()) {
    host_.KeepAlive();
    if (published_) published_->Turn();
    std::this_thread::sleep_for(50ms);
  }
}

// One that stands by and has lost its store is no rival of the one that has it now: it is
// not at fault but starts again.
void Server::Report(const job_service::StoreError& error) {
  host_.SetHealth(options_.standby ? intaglio_HEALTH_STARTING : intaglio_HEALTH_FAULT, {},
                  error.what());
  if (raised_ != error.what()) {
    host_.RaiseAlarm(intaglio_ALARM_FAULT, ErrorCodeName(ErrorCode::kIo), error.what());
  }
  raised_ = error.what();
}

std::optional<job_service::JobStore> Server::AwaitStore() {
  while (!host_.stopping()) {
    if (auto store = turn_.Try()) return store;
    host_.SetHealth(intaglio_HEALTH_STARTING, {},
                    "stands by: another job service has the queue");
    Pause(500ms);
  }
  return std::nullopt;
}

int Server::ServeQueue(job_service::JobStore store) {
  job_service::JobService service(host_, options_, std::move(store), turn_.seen(),
                                  published_->board, job_service::SinceBoot());
  host::PollLoop loop(host_.bus());
  service.AttachTo(loop);
  host_.SetHealth(intaglio_HEALTH_READY);
  opened_ = true;
  try {
    while (!host_.stopping()) {
      if (only_->MustEnd()) return only_->EndAsSecond("job service");
      service.Turn(job_service::SinceBoot());
      published_->services.SetLeftOut(service.LeftOutNow());
      host_.KeepAlive();
      published_->Turn();
      loop.Wait({}, 20ms);
    }
    service.Close(job_service::SinceBoot());
  } catch (const job_service::StoreError& error) {
    service.PublishFault(error.what());
    throw;
  }
  return 0;
}

// Nothing may follow from a change that is not stored. With a disk that is full, or a
// server that is away, the queue is given up, and every permission with it; it is read
// again as soon as it can be written. What is full at the start is waited for in the same
// way; a file that is no database of this program's ends it. Nothing is touched before it
// is known that no other job service is at work: by the owner of the store where several
// stand by, by the bus in any case.
int Server::Serve() {
  if (!options_.standby && !Begin()) return only_->EndAsSecond("job service");
  while (!host_.stopping()) {
    try {
      auto store = AwaitStore();
      if (!store) return 0;
      if (!only_ && !Begin()) return only_->EndAsSecond("job service");
      return ServeQueue(std::move(*store));
    } catch (const job_service::StoreError& error) {
      const bool is_taken = !options_.standby && sql::IsServerAddress(options_.database);
      if (!error.passes() && (!opened_ || is_taken)) throw;
      Report(error);
    }
    Pause(1s);
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
        app.AddOption("--database", options.database,
                      "the queue: a file, or postgresql://USER@HOST/DATABASE on a server")
            .Require();
        app.AddFlag("--standby", options.standby,
                    "wait while another job service has the queue of the server, and "
                    "take over when it ends");
        app.AddOption("--materials-db", options.materials, "material base").ShowDefault();
        app.AddOption("--results", options.results, "folder of the jobs' results")
            .Require();
        app.AddOption("--recording", options.recording,
                      "recording of the shop, for the history");
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Server(host, options).Serve();
  });
}
