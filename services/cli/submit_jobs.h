#pragma once

// Submitting jobs: one, one for each row of a table, one for each station of a table.

#include <cstdint>
#include <iostream>
#include <string>

#include "engrave/core/result.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/job/job_options.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

/// Options of the commands that submit jobs.
struct JobsOptions {
  bus::BusOptions bus;
  JobFlags job;
  std::string uid;
  std::string percent;
  std::string before;  ///< move
  bool last = false;   ///< move
  std::string series, stations;
  std::string id;  // of the submission; empty: a new one
  std::string materials_db;
  std::string folder = "intaglio-shop";
  std::string database;
  std::uint32_t from_point = 0;
  bool fire_uncertain = false;
  AcceptFlag accept;
  bool arm = false, same_block = false;
  std::string block_id;  ///< arm: of a loader; empty: a person arms
  bool watch = false;
  bool events = false, json = false;

  /// Where text for people goes.
  std::ostream& human() const { return events ? std::cerr : std::cout; }
};

/// What `intaglio submit` does; its exit code.
int Submit(const JobsOptions& options);

/// The next piece of a job: the same once more, on a new block.
int Again(const JobsOptions& options);

/// Follows a job to its end.
int Watch(client::JobClient& client, const std::string& uid, const JobsOptions& options);

/// There is no such shop or job, or there is one that cannot work.
int ComplainOfShop(const Error& error);

/// Exit codes of a command that got no answer, or not the one that was asked for.
int ComplainOf(const Error& error);

}  // namespace intaglio::cli
