#pragma once

// What the tests of JobStore share: a job with a value in every field, and an engraving
// of it.

#include <gtest/gtest.h>

#include <string>

#include "proto/task.pb.h"
#include "services/job_service/job_store.h"

namespace intaglio::job_service {

class JobStoreRig : public testing::Test {
 protected:
  static JobRecord Record(std::uint32_t number, intaglio_JobState state) {
    JobRecord job;
    job.number = number;
    job.uid = std::to_string(number) + "-abc";
    job.submission_uid = "s" + std::to_string(number);
    job.epoch = 0xabcdef0123456789;
    job.name = "a \"quoted\" name; DROP TABLE jobs";
    job.cell = "els-03";
    job.material = "N-BK7";
    job.priority = -3;
    job.turn = -(std::int64_t{1} << 40);
    job.rate_hz = 100;
    job.result_directory = "/results/" + job.uid;
    job.frozen_job = std::string("\0\1\2\xff", 4);
    job.state = state;
    job.attempt = 2;
    job.lost_attempts = 1;
    job.message = "two\nlines";
    job.estimate_ticks = 12345678901234;
    job.first_estimate_ticks = 12345678901235;
    job.stage(intaglio_STAGE_SORT) = {"sorter-1", true, 7, 8, 1.5};
    job.revision = 9;
    job.arm = JobArm({.ever_granted = true,
                      .disarm_count = 5,
                      .disarm_reason = "paused by ann",
                      .first_point = 17,
                      .fire_uncertain = true,
                      .last_command = 18446744073709551615u,
                      .last_command_id = "ann@shop-1/7"});
    job.pause_reason = intaglio_PAUSE_INTERLOCK;
    return job;
  }
  static TaskView EngraveEnd(intaglio_TaskState state) {
    TaskView end;
    end.task = {"1-abc", 2, 0, 0};
    end.stage = intaglio_STAGE_ENGRAVE;
    end.worker = "y";
    end.state = state;
    return end;
  }
  static std::string Outcome(std::uint64_t planned, std::uint64_t made) {
    StageOutcome outcome;
    outcome.mutable_engrave()->set_planned_count(planned);
    outcome.mutable_engrave()->set_made_count(made);
    outcome.mutable_engrave()->set_missed_count(planned - made);
    outcome.mutable_engrave()->set_used_ticks(2 * planned);
    outcome.mutable_engrave()->set_run_count(1);
    outcome.mutable_engrave()->set_min_speed_percent(100);
    return outcome.SerializeAsString();
  }
  static void GiveEngraving(JobStore& store) {
    TaskOrder order;
    order.worker = "y";
    order.stage = intaglio_STAGE_ENGRAVE;
    order.task = {"1-abc", 2, 0, 0};
    store.KeepTask(order);
  }
};

}  // namespace intaglio::job_service
