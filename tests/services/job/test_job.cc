#include "tests/services/job/test_job.h"

#include "services/job/files/job_file.h"

namespace intaglio {

JobSpec GoodJob() {
  JobSpec job = ReadJobFile(INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto").value();
  job.mutable_discretization()->mutable_sections();  // the quickest method
  return job;
}

MachineSpec GoodMachine() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
}

}  // namespace intaglio
