#include "services/cli/preview/named_job.h"

#include <cctype>
#include <filesystem>
#include <utility>

#include "engrave/core/try.h"
#include "services/history/job_history.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

/// A number as `list` shows it, or a uid, unless there is a file of that name.
bool IsJobOfShop(const std::string& text) {
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) != 0 &&
         fs::path(text).extension().empty() && !fs::exists(text);
}

}  // namespace

void AddShopOfJob(command_line::Command command, ShopOfJob& shop) {
  const auto folder =
      command
          .AddOption("--folder", shop.folder,
                     "folder of the shop of a job's number, as for intaglio up")
          .ShowDefault();
  command
      .AddOption(
          "--database", shop.database,
          "or the database of the job service, as for its --database: a file or a server")
      .Exclude(folder);
}

Result<JobAndMachine> FindNamedJob(const JobFlags& flags, const ShopOfJob& shop) {
  const auto& what = flags.what;
  if (what.size() != 1 || !IsJobOfShop(what.front())) return BuildJobOfAnyKind(flags);
  auto job = INTAGLIO_TRY(history::ReadJob(
      shop.database.empty() ? shop.folder + "/jobs.db" : shop.database, what.front()));
  return CompleteJob(flags, std::move(job));
}

}  // namespace intaglio::cli
