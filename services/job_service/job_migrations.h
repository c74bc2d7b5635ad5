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
)sql"};

}  // namespace intaglio::job_service
