#include "tests/services/job/test_job.h"

#include "services/job/job_file.h"

namespace intaglio {

JobSpec GoodJob() {
  return ReadJobFile(INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto").value();
}

MachineSpec GoodMachine() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
}

}  // namespace intaglio
