#pragma once

// The machines of the campaigns that are judged by true place: one row each.

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "tests/integration/campaign/fault_rows.h"
#include "tests/integration/campaign/true_account.h"

namespace intaglio::campaign {

/// Where a shop and its machine leave what is judged.
struct Records {
  std::filesystem::path machine;  ///< folder of the machine's own records
  std::filesystem::path job;      ///< folder of the job
};

struct MachineRow {
  enum class Controller { kGrbl, kScanHead };
  const char* name;
  const char* profile;  ///< of deploy/machines
  Controller controller;
  /// Options of the virtual controller.
  std::vector<std::string> options;
  /// Fields of the profile in place of those that begin alike.
  std::vector<std::pair<std::string, std::string>> fields;
  std::vector<std::string> mounted;  ///< arguments of `intaglio up`
  std::string job;                   ///< without machine_file
  std::string drawing;               ///< drawing.svg beside it, if not empty
  std::vector<std::string> services;
  const char* line_service;  ///< has the line to the controller
  /// The controller draws a number at each power-up, which outlives that service.
  bool numbers_power_ups;
  double near_mm;  ///< work belongs to an item that is so near
  double amount;   ///< of the whole job, about (AmountOf)
  /// What the job asks for; `work` was made before anything happened.
  Result<std::vector<Item>> (*items)(const Records&, const std::vector<WorkPiece>& work);
  std::vector<WorkPiece> (*work)(const Records&);
};

const std::vector<MachineRow>& MachineRows();

/// Whether the row can happen there.
bool HasFault(const MachineRow& machine, const FaultRow& fault);
bool NeedsPerson(const MachineRow& machine, const FaultRow& fault);
/// The tool's place may be lost, and the machine has no switches.
bool LosesPlace(const MachineRow& machine, const FaultRow& fault);

}  // namespace intaglio::campaign
