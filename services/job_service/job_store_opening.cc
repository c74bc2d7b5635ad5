// How JobStore is opened: the connection, who owns it, the versions of its tables, and
// the run that begins.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>
#include <thread>
#include <utility>

#include "services/history/job_database.h"
#include "services/history/job_history.h"
#include "services/job_service/job_migrations.h"
#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;

static_assert(kMigrations.size() == history::kJobDatabaseVersion);

}  // namespace

std::unique_ptr<sql::Connection> OpenStore(const std::string& address) {
  if (!sql::IsServerAddress(address)) {
    if (const auto intact = history::CheckQueue(address); !intact)
      throw StoreError(intact.error().message, intact.error().code == ErrorCode::kIo);
    std::error_code ignored;
    fs::create_directories(fs::path(address).parent_path(), ignored);
  }
  try {
    return sql::Open(address);
  } catch (const sql::SqlError& error) {
    throw ErrorOf(address, error);
  }
}

JobStore::JobStore(std::unique_ptr<sql::Connection> owned) : database_(std::move(owned)) {
  Migrate();
}

JobStore::JobStore(const std::string& address) : database_(OpenStore(address)) {
  Guarded(*database_, [this] {
    // A server ends the session of a job service that has just ended a moment later.
    constexpr std::chrono::seconds kPatience{6};
    const auto end = std::chrono::steady_clock::now() + kPatience;
    do {
      if (database_->TryOwn()) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    } while (std::chrono::steady_clock::now() < end);
    throw StoreError(
        fmt::format("job database {}: another job service has it; end that one, or start "
                    "this one with --standby to take over when the other one ends",
                    database_->Place()),
        false);
  });
  Migrate();
}

JobStore::JobStore(JobStore&&) noexcept = default;

JobStore::~JobStore() = default;

void JobStore::Migrate() {
  Guarded(*database_, [this] {
    const int version = database_->Version();
    const int newest = static_cast<int>(kMigrations.size());
    if (version > newest) {
      throw StoreError(
          fmt::format("job database {} has version {}, this program supports "
                      "{}; use the newer program; nothing was changed",
                      database_->Place(), version, newest),
          false);
    }
    for (int next = version; next < newest; ++next) {
      sql::Transaction transaction(*database_);
      database_->Run(kMigrations.at(static_cast<std::size_t>(next)));
      database_->SetVersion(next + 1);
      transaction.Commit();
    }
    if (version > 0 && version < history::kHistoryVersion) FillInHistory();
  });
}

std::string JobStore::Note() {
  return Guarded(*database_, [this] { return database_->Note(); });
}

void JobStore::KeepNote(const std::string& text) {
  Guarded(*database_, [&] { database_->KeepNote(text); });
}

std::uint64_t JobStore::BeginRun() {
  return Guarded(*database_, [this] {
    using std::chrono::seconds;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    // Seconds and 16 random bits: two databases started in one second differ as well.
    const std::int64_t fresh = std::chrono::duration_cast<seconds>(now).count() << 16 |
                               (std::random_device()() & 0xffff);
    sql::Transaction transaction(*database_);
    const std::int64_t last =
        sql::IntegerOf(*database_, "SELECT coalesce(max(epoch), 0) FROM runs");
    const std::int64_t epoch = std::max(fresh, last + 1);
    const auto insert = database_->Prepare("INSERT INTO runs VALUES (?, ?)");
    insert->Bind(1, epoch);
    insert->Bind(2, NowUtc());
    insert->Execute();
    transaction.Commit();
    return static_cast<std::uint64_t>(epoch);
  });
}

}  // namespace intaglio::job_service
