#include "services/cli/backup/backup_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "engrave/core/counted.h"
#include "materials_db/material_store.h"
#include "services/backup/shop_backup.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/fresh_paths.h"
#include "services/client/locks/folder_lock.h"
#include "services/sql/address.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct BackupOptions {
  std::string file;
  std::string folder = "intaglio-shop";
  std::string database, results, materials, machines;
  std::vector<std::string> without;
  bool replace = false;
  bool list = false;
};

backup::ShopPlaces PlacesOf(const BackupOptions& options) {
  const fs::path folder = fs::absolute(options.folder);
  const auto place = [](const std::string& named, const fs::path& usual) {
    return named.empty() ? usual : fs::absolute(named);
  };
  return {place(options.database, folder / "jobs.db"),
          place(options.results, folder / "jobs"),
          place(options.materials, materials_db::DefaultDatabasePath()),
          place(options.machines, folder)};
}

/// A line for each part, with the number and size of its files.
void PrintParts(const std::vector<backup::ArchivedFile>& files) {
  struct Sum {
    std::uint64_t files = 0, bytes = 0;
  };
  std::map<std::string, Sum> sums;
  for (const backup::ArchivedFile& file : files) {
    Sum& sum = sums[fs::path(file.name).begin()->string()];
    ++sum.files;
    sum.bytes += file.bytes;
  }
  for (const char* part : backup::kParts) {
    fmt::print(std::cout, "{:<10} {:>8} {:<5} {:>16} bytes\n", part,
               client::GroupedDigits(sums[part].files), NounFor(sums[part].files, "file"),
               client::GroupedDigits(sums[part].bytes));
  }
}

/// The queue of a server is kept by its own tools.
Status CheckQueueIsFile(const BackupOptions& options) {
  const auto& without = options.without;
  const bool has_queue =
      std::find(without.begin(), without.end(), "queue") == without.end();
  if (!has_queue || !sql::IsServerAddress(options.database)) return {};
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("--database {}: this queue is on a server: add --without queue, "
                  "and keep it with pg_dump --schema intaglio",
                  sql::WithoutPassword(options.database)),
      "--database");
}

int BackUp(const BackupOptions& options) {
  if (auto file = CheckQueueIsFile(options); !file) return Complain(file.error());
  const auto files = backup::BackUp(
      PlacesOf(options), {options.without.begin(), options.without.end()}, options.file);
  if (!files) return Complain(files.error());
  PrintParts(*files);
  std::cout << "written to " << options.file << "\n";
  return client::kExitGood;
}

int List(const backup::Archive& archive) {
  std::cout << "made " << archive.made_utc() << ", of the jobs in " << archive.results()
            << "\n";
  for (const backup::ArchivedFile& file : archive.files()) {
    fmt::print(std::cout, "{:>16}  {:08x}  {}\n", client::GroupedDigits(file.bytes),
               file.crc32, file.name);
  }
  PrintParts(archive.files());
  return client::kExitGood;
}

int Restore(const BackupOptions& options) {
  if (auto file = CheckQueueIsFile(options); !file) return Complain(file.error());
  const auto archive = backup::Archive::Open(options.file);
  if (!archive) return Complain(archive.error());
  if (options.list) return List(*archive);
  const fs::path folder = fs::absolute(options.folder);
  client::FreshPaths fresh({folder, folder / "lock"});
  // A queue that is named by itself is not in a folder of `up`.
  std::optional<client::FolderLock> lock;
  if (options.database.empty()) {
    auto taken = client::FolderLock::Take(folder);
    if (!taken) return Complain(taken.error());
    lock.emplace(std::move(*taken));
  }
  const backup::RestoreOptions restore{PlacesOf(options),
                                       {options.without.begin(), options.without.end()},
                                       options.replace};
  const auto kept = backup::Restore(*archive, restore);
  if (!kept) return Complain(kept.error());
  if (lock) fresh.Keep();
  PrintParts(archive->files());
  for (const fs::path& path : *kept) std::cout << "kept " << path.string() << "\n";
  std::cout << "restored as of " << archive->made_utc()
            << "; no job is armed, and what had begun to be made then is ended\n";
  return client::kExitGood;
}

void AddPlaces(command_line::Command command, BackupOptions& options) {
  command.AddOption("--folder", options.folder, "folder of the shop, as for intaglio up")
      .ShowDefault();
  command.AddOption("--database", options.database,
                    "file of the queue, as for intaglio-job-service; default jobs.db in "
                    "the folder");
  command.AddOption("--results", options.results,
                    "folder of the jobs, as for intaglio-job-service; default jobs in "
                    "the folder");
  command.AddOption("--materials", options.materials,
                    "material base, default the user's");
  command.AddOption("--machines", options.machines,
                    "folder of machine profiles, default the shop's folder");
  command
      .AddOption("--without", options.without,
                 "parts that are left out: queue, jobs, materials, machines")
      .OneOf({std::begin(backup::kParts), std::end(backup::kParts)});
}

void AddBackup(command_line::Command app) {
  auto options = std::make_shared<BackupOptions>();
  command_line::Command command = app.AddCommand(
      "backup", "write queue, journals, glasses and profiles of a shop to one file");
  command.AddOption("FILE", options->file, "the backup, a new file").Require();
  AddPlaces(command, *options);
  command.SetFooter(
      "Example: intaglio backup shop-2026-11-26.backup --folder shop\n"
      "The shop may be open or closed. Recordings are not in it.");
  command.SetAction([options] { return BackUp(*options); });
}

void AddRestore(command_line::Command app) {
  auto options = std::make_shared<BackupOptions>();
  command_line::Command command = app.AddCommand(
      "restore", "put what intaglio backup has written to its places again");
  command.AddOption("FILE", options->file, "the backup").Require();
  AddPlaces(command, *options);
  const auto replace = command.AddFlag(
      "--replace", options->replace,
      "what is there already is renamed to NAME.replaced-TIME; else it is refused");
  command
      .AddFlag("--list", options->list,
               "print what is in the backup, and restore nothing")
      .Exclude(replace);
  command.SetFooter(
      "Example: intaglio restore shop-2026-11-26.backup --folder shop --replace\n"
      "The shop has to be closed. All checksums are compared before anything is "
      "changed.");
  command.SetAction([options] { return Restore(*options); });
}

}  // namespace

void AddBackupCommands(command_line::Command app) {
  AddBackup(app);
  AddRestore(app);
}

}  // namespace intaglio::cli
