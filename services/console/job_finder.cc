#include "services/console/job_finder.h"

#include <utility>

#include "services/history/job_history.h"

namespace intaglio::console {
namespace {

Result<FoundJob> FindInDatabase(const std::string& database, const std::string& job) {
  auto found = history::FindJobFolder(database, job);
  if (!found) return tl::unexpected(found.error());
  return FoundJob{found->number, std::move(found->folder)};
}

}  // namespace

FindJob JobFinder(ShopDesk& shop, CloudReader& files, std::string database) {
  return [&shop, &files, database = std::move(database)](
             std::string job, std::function<void(Result<FoundJob>)> found) {
    shop.Order([&shop, &files, database, job = std::move(job),
                found = std::move(found)](ShopDesk& desk) {
      const auto view = desk.client().Find(job);
      if (view) return found(FoundJob{view->number, view->result_directory});
      if (database.empty()) return found(tl::unexpected(view.error()));
      const bool asked = files.Ask([&shop, database, job, found] {
        auto read = FindInDatabase(database, job);
        shop.Order([found, read = std::move(read)](ShopDesk&) { found(read); });
      });
      if (!asked) found(Fail(ErrorCode::kRefused, "too many files are asked for", job));
    });
  };
}

}  // namespace intaglio::console
