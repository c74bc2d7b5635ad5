#pragma once

// A task that is right in every field, for tests to break: the sample job on els-03.

#include "materials_db/material_store.h"
#include "services/job/files/freeze.h"
#include "tests/services/job/test_job.h"

namespace intaglio::synchronizer {

inline FrozenJob GoodTask(const std::string& glass = "N-BK7") {
  const auto materials = materials_db::MaterialStore::Open(":memory:");
  JobSpec job = GoodJob();
  job.set_glass(glass);
  return FreezeJob(job, GoodMachine(), materials->Find(glass).value(),
                   {"job", 1, "/nowhere", "test"})
      .value();
}

}  // namespace intaglio::synchronizer
