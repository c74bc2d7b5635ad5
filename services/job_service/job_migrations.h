#pragma once

// The tables of job_store.h, from version to version.

#include <array>

namespace intaglio::job_service {

// One entry a version; never changed once released, only added to.
inline constexpr std::array kMigrations = {
    R"sql(
CREATE TABLE runs (epoch INTEGER PRIMARY KEY, started_utc TEXT NOT NULL);
CREATE TABLE jobs (
  number INTEGER PRIMARY KEY,
  uid TEXT NOT NULL UNIQUE,
  submission_uid TEXT NOT NULL,
  epoch INTEGER NOT NULL,
  name TEXT NOT NULL,
  cell TEXT NOT NULL,
  rate_hz REAL NOT NULL,
  result_directory TEXT NOT NULL,
  frozen_job BLOB NOT NULL,
  state INTEGER NOT NULL,
  ended INTEGER NOT NULL,
  attempt INTEGER NOT NULL,
  lost_attempts INTEGER NOT NULL,
  message TEXT NOT NULL,
  estimate_ticks INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  last_command INTEGER NOT NULL,
  ever_granted INTEGER NOT NULL,
  changed_utc TEXT NOT NULL
);
CREATE INDEX jobs_ended ON jobs (ended, number);
CREATE TABLE stages (
  job_uid TEXT NOT NULL REFERENCES jobs (uid),
  stage INTEGER NOT NULL,
  worker TEXT NOT NULL,
  done INTEGER NOT NULL,
  done_count INTEGER NOT NULL,
  total_count INTEGER NOT NULL,
  elapsed_s REAL NOT NULL,
  PRIMARY KEY (job_uid, stage)
);
CREATE TABLE submissions (
  submission_uid TEXT PRIMARY KEY,
  refusal TEXT NOT NULL,
  taken_utc TEXT NOT NULL
);
CREATE TABLE commands (
  job_uid TEXT NOT NULL,
  number INTEGER NOT NULL,
  kind INTEGER NOT NULL,
  operator_name TEXT NOT NULL,
  taken_utc TEXT NOT NULL,
  PRIMARY KEY (job_uid, number)
);
CREATE TABLE tasks (
  job_uid TEXT NOT NULL,
  attempt INTEGER NOT NULL,
  stage INTEGER NOT NULL,
  worker TEXT NOT NULL,
  given_utc TEXT NOT NULL,
  revoked_utc TEXT,
  ended_utc TEXT,
  state INTEGER,
  message TEXT,
  outcome BLOB,
  PRIMARY KEY (job_uid, attempt, stage)
);
)sql",
    // A stage may be handed out in parts.
    R"sql(
CREATE TABLE tasks_in_parts (
  job_uid TEXT NOT NULL,
  attempt INTEGER NOT NULL,
  stage INTEGER NOT NULL,
  part INTEGER NOT NULL,
  part_attempt INTEGER NOT NULL,
  worker TEXT NOT NULL,
  given_utc TEXT NOT NULL,
  revoked_utc TEXT,
  ended_utc TEXT,
  state INTEGER,
  message TEXT,
  outcome BLOB,
  PRIMARY KEY (job_uid, attempt, stage, part, part_attempt)
);
INSERT INTO tasks_in_parts SELECT job_uid, attempt, stage, 0, 0, worker, given_utc,
  revoked_utc, ended_utc, state, message, outcome FROM tasks;
DROP TABLE tasks;
ALTER TABLE tasks_in_parts RENAME TO tasks;
)sql",
    // The history: what became of a job, and where it lies (services/history). Texts are
    // empty until they are known.
    R"sql(
ALTER TABLE jobs ADD COLUMN priority INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN material TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN started_utc TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN engraving_utc TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN ended_utc TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN verdict TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN planned_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN made_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN missed_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN skipped_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN uncertain_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN used_ticks INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN report TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN recording TEXT NOT NULL DEFAULT '';
CREATE INDEX jobs_history ON jobs (ended_utc, number);
UPDATE jobs SET ended_utc = changed_utc WHERE ended = 1;
UPDATE jobs SET started_utc = coalesce(
  (SELECT min(given_utc) FROM tasks WHERE tasks.job_uid = jobs.uid), '');
)sql",
    // Whether a job goes on by itself after a loss.
    R"sql(
ALTER TABLE jobs ADD COLUMN armed INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN operator_name TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN asks_before_resume INTEGER NOT NULL DEFAULT 1;
)sql",
    // What the operator leaves out.
    R"sql(
ALTER TABLE jobs ADD COLUMN first_point INTEGER NOT NULL DEFAULT 0;
)sql",
    // Whether the newest command allows it to fire what is uncertain.
    R"sql(
ALTER TABLE jobs ADD COLUMN fire_uncertain INTEGER NOT NULL DEFAULT 0;
)sql",
    // A command belongs to its sender and is kept with its answer (code 0: taken); older
    // ones, which jobs numbered, have their job for the sender.
    R"sql(
ALTER TABLE jobs ADD COLUMN disarm_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN disarm_reason TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN last_command_id TEXT NOT NULL DEFAULT '';
CREATE TABLE answered_commands (
  sender TEXT NOT NULL,
  number INTEGER NOT NULL,
  job_uid TEXT NOT NULL,
  kind INTEGER NOT NULL,
  operator_name TEXT NOT NULL,
  code INTEGER NOT NULL,
  message TEXT NOT NULL,
  taken_utc TEXT NOT NULL,
  PRIMARY KEY (sender, number)
);
INSERT INTO answered_commands SELECT job_uid, number, job_uid, kind, operator_name, 0, '',
  taken_utc FROM commands;
DROP TABLE commands;
ALTER TABLE answered_commands RENAME TO commands;
)sql",
    // Why a job is paused, as a PauseReason: 1 operator, 3 fault. Before, only the
    // message had it. 5: JOB_PAUSED.
    R"sql(
ALTER TABLE jobs ADD COLUMN pause_reason INTEGER NOT NULL DEFAULT 0;
UPDATE jobs SET pause_reason = CASE WHEN message LIKE 'paused by %' THEN 1 ELSE 3 END
  WHERE state = 5;
)sql",
    // The warnings of a job, a serialized WarningList, and who accepted that the glass
    // may break. Before, warnings were sentences in the outcomes of tasks alone.
    R"sql(
ALTER TABLE jobs ADD COLUMN warnings BLOB NOT NULL DEFAULT x'';
ALTER TABLE jobs ADD COLUMN breakage_accepted_by TEXT NOT NULL DEFAULT '';
)sql",
    // Marks the file: "INTJ" (services/history/job_database.h).
    R"sql(
PRAGMA application_id = 1229870154;
)sql",
    // The first estimate of the machining time, and what both estimates are compared
    // with: the ticks of a job that was made whole in one run at full speed.
    R"sql(
ALTER TABLE jobs ADD COLUMN first_estimate_ticks INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN undisturbed_ticks INTEGER NOT NULL DEFAULT 0;
)sql",
    // What a job makes, points or marks.
    R"sql(
ALTER TABLE jobs ADD COLUMN makes TEXT NOT NULL DEFAULT 'points';
)sql",
    // What is known of the machines: whose block is in each, the blocks of loaders, and
    // what people reported as mounted. What an arm was based on, as an ArmBasis: 1 a
    // person.
    R"sql(
CREATE TABLE pieces (
  cell TEXT PRIMARY KEY,
  job_uid TEXT NOT NULL,
  job_number INTEGER NOT NULL,
  opened INTEGER NOT NULL,
  stations TEXT NOT NULL,
  block TEXT NOT NULL
);
CREATE TABLE loaded_blocks (
  cell TEXT NOT NULL,
  block_id TEXT NOT NULL,
  job_uid TEXT NOT NULL,
  loaded_utc TEXT NOT NULL,
  PRIMARY KEY (cell, block_id)
);
CREATE TABLE mounts (
  number INTEGER PRIMARY KEY,
  cell TEXT NOT NULL,
  block_x_mm REAL NOT NULL,
  block_y_mm REAL NOT NULL,
  block_z_mm REAL NOT NULL,
  glass TEXT NOT NULL,
  refractive_index REAL NOT NULL,
  lens TEXT NOT NULL,
  focal_length_mm REAL NOT NULL,
  numerical_aperture REAL NOT NULL,
  piece TEXT NOT NULL,
  operator_name TEXT NOT NULL,
  mounted_utc TEXT NOT NULL
);
ALTER TABLE jobs ADD COLUMN block_id TEXT NOT NULL DEFAULT '';
ALTER TABLE commands ADD COLUMN basis INTEGER NOT NULL DEFAULT 1;
)sql",
    // The order that people have given the queue; kTurnStep apart.
    R"sql(
ALTER TABLE jobs ADD COLUMN turn INTEGER NOT NULL DEFAULT 0;
UPDATE jobs SET turn = number * 1048576;
)sql",
    // Workers that are given nothing more.
    R"sql(
CREATE TABLE left_out (
  worker TEXT PRIMARY KEY,
  why TEXT NOT NULL,
  for_good INTEGER NOT NULL,
  since_utc TEXT NOT NULL
);
)sql",
    // What became of workers, for the history; and the refused commands in the order in
    // which they came, of which the newest stay.
    R"sql(
CREATE TABLE worker_events (
  number INTEGER PRIMARY KEY,
  worker TEXT NOT NULL,
  event TEXT NOT NULL,
  why TEXT NOT NULL,
  operator_name TEXT NOT NULL,
  at_utc TEXT NOT NULL
);
CREATE INDEX commands_refused ON commands (taken_utc) WHERE code <> 0;
CREATE INDEX submissions_refused ON submissions (taken_utc) WHERE refusal <> '';
)sql"};

}  // namespace intaglio::job_service
