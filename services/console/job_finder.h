#pragma once

// Where the files of a job are, by its number or uid: as the job service publishes it, or
// as its database has it of a job that has left the bus.

#include <string>

#include "services/console/answers/find_job.h"
#include "services/console/cloud_reader.h"
#include "services/console/shop_desk.h"

namespace intaglio::console {

/// `database`: of the job service, empty: not known. All live longer than what is asked.
FindJob JobFinder(ShopDesk& shop, CloudReader& files, std::string database);

}  // namespace intaglio::console
