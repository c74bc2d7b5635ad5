#include "services/console/job_finder.h"

#include <utility>

#include "services/history/job_history.h"

namespace intaglio::console {

FindJob JobFinder(ShopDesk& shop, CloudReader& files, std::string database) {
  return [&shop, &files, database = std::move(database)](
             std::string job, std::function<void(Result<FoundJob>)> found) {
    shop.Order([&shop, &files, database, job = std::move(job),
                found = std::move(found)](ShopDesk& desk) {
      const auto view = desk.client().Find(job);
      if (view) return found(FoundJob{view->number, view->result_directory});
      if (database.empty()) return found(tl::unexpected(view.error()));
      const bool asked = files.Ask([&shop, database, job, found] {
        shop.Order([found, read = history::FindJobFolder(database, job)](ShopDesk&) {
          found(read);
        });
      });
      if (!asked) found(Fail(ErrorCode::kRefused, "too many files are asked for", job));
    });
  };
}

}  // namespace intaglio::console
