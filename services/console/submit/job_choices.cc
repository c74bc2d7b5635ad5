#include "services/console/submit/job_choices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/optics/absorption.h"
#include "engrave/optics/dispersion.h"
#include "materials_db/material_store.h"
#include "services/job/files/job_file.h"
#include "services/platform/command_line/supplied_files.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;
using command_line::kSuppliedProfiles;

constexpr double kShownNm = 532;
constexpr double kShownThicknessMm = 100;

GlassChoice ChoiceOf(const materials_db::Material& glass) {
  GlassChoice choice;
  choice.set_name(glass.name);
  choice.set_manufacturer(glass.manufacturer);
  if (const auto index = optics::RefractiveIndex(glass.dispersion, kShownNm))
    choice.set_index(*index);
  if (const auto per_mm = optics::AbsorptionPerMm(glass.transmittance, kShownNm))
    choice.set_transmitted_ratio(std::exp(-*per_mm * kShownThicknessMm));
  return choice;
}

double TravelOf(const AxisLimits& axis) {
  return axis.travel_max_mm() - axis.travel_min_mm();
}

std::string KinematicsOf(const MachineSpec& machine) {
  const auto* field = ChosenField(machine, "kinematics");
  return field == nullptr ? "cartesian" : field->name();
}

const char* WhatIsMadeBy(const MachineSpec& machine) {
  if (!machine.has_mark_line()) return "points";
  return machine.has_course_tool() ? "courses" : "marks";
}

void AddLaser(const LaserHead& laser, MachineChoice& choice) {
  const auto& rates_hz = laser.rates_hz();
  if (!rates_hz.empty())
    choice.set_max_rate_hz(*std::max_element(rates_hz.begin(), rates_hz.end()));
  choice.set_wavelength_nm(laser.wavelength_nm());
  choice.set_channels(laser.channels());
}

/// nullopt: it cannot be read.
std::optional<MachineChoice> ChoiceOf(const fs::path& profile, std::string machine_file) {
  const auto machine = ReadMachineFile(profile);
  if (!machine) return std::nullopt;
  MachineChoice choice;
  choice.set_machine_file(std::move(machine_file));
  choice.set_name(machine->name());
  choice.set_makes(WhatIsMadeBy(*machine));
  choice.set_kinematics(KinematicsOf(*machine));
  choice.mutable_travel_mm()->set_x(TravelOf(machine->x()));
  choice.mutable_travel_mm()->set_y(TravelOf(machine->y()));
  choice.mutable_travel_mm()->set_z(TravelOf(machine->z()));
  if (!machine->has_mark_line()) AddLaser(machine->laser(), choice);
  return choice;
}

/// By its profile: that of the shop in its file, and a supplied one by its name, unless
/// the shop has a machine of this name.
std::vector<MachineChoice> ListMachines(const std::vector<ShopMachine>& shop) {
  std::map<fs::path, std::string> supplied;
  for (const auto& name : command_line::SuppliedNames(kSuppliedProfiles)) {
    if (const auto file = command_line::FindSupplied(name, kSuppliedProfiles))
      supplied[*file] = name;
  }
  std::map<fs::path, MachineChoice> of_shop;
  std::error_code error;
  for (const ShopMachine& machine : shop) {
    const fs::path profile = fs::weakly_canonical(machine.profile, error);
    if (const auto known = of_shop.find(profile); known != of_shop.end()) {
      known->second.add_cells(machine.cell);
      continue;
    }
    const auto name = supplied.find(profile);
    auto choice = ChoiceOf(
        profile, name == supplied.end() ? machine.profile.string() : name->second);
    if (!choice) continue;
    choice->add_cells(machine.cell);
    of_shop[profile] = std::move(*choice);
  }
  std::vector<MachineChoice> machines;
  std::set<std::string> names;
  for (auto& [profile, choice] : of_shop) {
    names.insert(choice.name());
    machines.push_back(std::move(choice));
  }
  for (const auto& [profile, name] : supplied) {
    auto choice = ChoiceOf(profile, name);
    if (choice && !names.contains(choice->name())) machines.push_back(std::move(*choice));
  }
  return machines;
}

}  // namespace

Result<JobChoices> ListJobChoices(const std::vector<ShopMachine>& shop,
                                  const std::string& materials) {
  JobChoices choices;
  const auto store = INTAGLIO_TRY(
      materials_db::MaterialStore::Open(materials_db::DatabasePathOf(materials)));
  const auto glasses = INTAGLIO_TRY(store.List());
  for (const materials_db::Material& glass : glasses)
    *choices.add_glasses() = ChoiceOf(glass);
  for (MachineChoice& machine : ListMachines(shop))
    *choices.add_machines() = std::move(machine);
  return choices;
}

}  // namespace intaglio::console
