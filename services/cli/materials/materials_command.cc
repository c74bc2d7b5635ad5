#include "services/cli/materials/materials_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "materials_db/export_rii.h"
#include "materials_db/import_file.h"
#include "materials_db/material_store.h"
#include "materials_db/numbers.h"
#include "services/cli/job/job_options.h"
#include "services/cli/materials/glass_text.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/checks/mark_job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/files/material_record.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/quality/pulse_focus.h"

namespace intaglio::cli {
namespace {

using materials_db::Material;
using materials_db::MaterialStore;
using materials_db::PropertyRow;
using materials_db::PropertyRows;

/// What was given on the command line; of the subcommand that was chosen.
struct Flags {
  std::string database;
  std::string name;
  std::vector<std::string> files;
  std::string from;
  std::string as;
  std::string out;
  std::optional<double> wavelength_nm, numerical_aperture, focal_mm;
  std::string machine = "els-03";
  bool replace = false;
  bool skip_bad = false;
  bool json = false;
  std::optional<std::string> manufacturer;
  std::optional<std::string> source;
  std::optional<std::string> formula;
  std::vector<std::string> coefficients;
  std::vector<double> range_um;
  materials_db::Properties properties;
};

using Action = Status (*)(const Flags& flags, MaterialStore& store);

struct Beam {
  PrintedLight light;
  /// Absent where both values of the light are given on the command line.
  std::optional<LaserHead> laser = {};
  MachineLens lens = {};
};

/// Reads the machine's laser and its mounted lens, or that with --focal; what is given
/// on the command line comes first.
Result<Beam> BeamOf(const Flags& flags) {
  if (flags.wavelength_nm && flags.numerical_aperture) {
    return Beam{PrintedLight{*flags.wavelength_nm, *flags.numerical_aperture}};
  }
  const auto file = INTAGLIO_TRY(FindMachineFile(flags.machine));
  const auto profile = INTAGLIO_TRY(ReadMachineFile(file.string()));
  INTAGLIO_TRY(CheckMakesPoints(profile));
  const MachineSpec machine = ForWavelength(
      flags.wavelength_nm.value_or(profile.laser().wavelength_nm()), profile);
  const MachineLens* lens =
      flags.focal_mm ? FindLens(machine, *flags.focal_mm) : MountedLensOf(machine);
  if (lens == nullptr) {
    std::vector<double> lengths_mm;
    for (const MachineLens& l : machine.lenses())
      lengths_mm.push_back(l.focal_length_mm());
    return Fail(ErrorCode::kNotFound,
                fmt::format("--focal: {} has no lens of {} mm; it has {}", machine.name(),
                            flags.focal_mm.value_or(0), fmt::join(lengths_mm, " ")),
                machine.name());
  }
  return Beam{PrintedLight{flags.wavelength_nm.value_or(machine.laser().wavelength_nm()),
                           flags.numerical_aperture.value_or(lens->numerical_aperture())},
              machine.laser(), *lens};
}

// ---- What is known -------------------------------------------------------------

Status List(const Flags& flags, MaterialStore& store) {
  const auto materials = INTAGLIO_TRY(store.List());
  const PrintedLight light = INTAGLIO_TRY(BeamOf(flags)).light;
  if (flags.json) {
    std::cout << GlassesAsJson(materials, light) << "\n";
  } else {
    const auto aliases = INTAGLIO_TRY(store.Aliases());
    std::cout << GlassesAsTable(materials, aliases, light);
  }
  return {};
}

/// The stored values are shown also for a glass for which nothing can be computed at this
/// wavelength.
Status Show(const Flags& flags, MaterialStore& store) {
  const auto material = INTAGLIO_TRY(store.Find(flags.name));
  const Beam beam = INTAGLIO_TRY(BeamOf(flags));
  const PrintedLight& light = beam.light;
  const auto optics = materials_db::ComputeOptics(material, light.wavelength_nm,
                                                  light.numerical_aperture);
  std::optional<PulseFocusRecord> focus;
  if (optics && beam.laser) {
    focus = PulseFocusOf(RecordOf(material),
                         RecordOf(*optics, light.wavelength_nm, light.numerical_aperture),
                         *beam.laser, beam.lens);
  }
  if (flags.json) {
    std::cout << GlassAsJson(material, light, focus) << "\n";
  } else {
    const auto aliases = INTAGLIO_TRY(store.Aliases());
    std::cout << GlassAsTable(material, aliases);
    if (optics) std::cout << "\n" << OpticsAsTable(*optics, light);
    if (focus) std::cout << "\n" << FocusAsTable(*focus);
  }
  if (!optics) return tl::unexpected(optics.error());
  return {};
}

// ---- Changes -----------------------------------------------------------------

/// Puts what was given on the command line into `material`; leaves the rest.
Status ApplyFields(const Flags& flags, Material& material) {
  if (flags.manufacturer) material.manufacturer = *flags.manufacturer;
  if (flags.source) material.source = *flags.source;
  if (flags.formula) {
    const auto formula = INTAGLIO_TRY(optics::DispersionFormulaFromName(*flags.formula));
    material.dispersion.formula = formula;
  }
  if (!flags.coefficients.empty()) {
    const std::string text = fmt::format("{}", fmt::join(flags.coefficients, " "));
    const auto numbers = materials_db::ParseNumbers(text);
    if (!numbers) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--coefficients must be numbers, not \"{}\"", text), text);
    }
    material.dispersion.coefficients = *numbers;
  }
  if (!flags.range_um.empty()) {
    material.dispersion.min_wavelength_um = flags.range_um[0];
    material.dispersion.max_wavelength_um = flags.range_um[1];
  }
  for (const PropertyRow& row : PropertyRows()) {
    if (flags.properties.*row.value) material.*row.value = flags.properties.*row.value;
  }
  return {};
}

Status Add(const Flags& flags, MaterialStore& store) {
  Material material;
  material.name = flags.name;
  INTAGLIO_TRY(ApplyFields(flags, material));
  INTAGLIO_TRY(store.Add(material));
  std::cout << material.name << ": added\n";
  return {};
}

/// The one glass of a file, or the one of that name among several.
Result<Material> ReadOne(const std::string& file, const std::string& name) {
  auto imported = materials_db::ImportFile(file);
  if (!imported.errors.empty()) return tl::unexpected(imported.errors.front());
  if (imported.materials.size() == 1) return std::move(imported.materials.front());
  for (Material& material : imported.materials) {
    if (material.name == name) return std::move(material);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("{}: has {}, none of them named {}", file,
                          Counted(imported.materials.size(), "glass", "glasses"), name),
              name);
}

Status Replace(const Flags& flags, MaterialStore& store) {
  const auto present = INTAGLIO_TRY(store.Find(flags.name));
  Material material = present;
  if (!flags.from.empty()) {
    auto read = INTAGLIO_TRY(ReadOne(flags.from, present.name));
    material = std::move(read);
    material.name = present.name;
  }
  INTAGLIO_TRY(ApplyFields(flags, material));
  if (material == present) {
    return Fail(
        ErrorCode::kMissing,
        fmt::format("no new value for glass {}; give a field, or a file with --from",
                    present.name),
        present.name);
  }
  INTAGLIO_TRY(store.Replace(material));
  std::cout << material.name << ": replaced\n";
  return {};
}

Status Remove(const Flags& flags, MaterialStore& store) {
  INTAGLIO_TRY(store.Remove(flags.name));
  std::cout << flags.name << ": removed\n";
  return {};
}

Status Import(const Flags& flags, MaterialStore& store) {
  std::vector<Material> materials;
  std::vector<Error> errors;
  for (const std::string& file : flags.files) {
    auto imported = materials_db::ImportFile(file);
    std::move(imported.materials.begin(), imported.materials.end(),
              std::back_inserter(materials));
    std::move(imported.errors.begin(), imported.errors.end(), std::back_inserter(errors));
  }
  if (!errors.empty() && (!flags.skip_bad || materials.empty())) {
    Error all = errors.front();
    for (std::size_t i = 1; i < errors.size(); ++i) {
      all.message += "\n" + errors[i].message;
    }
    if (!materials.empty()) {
      all.message += fmt::format(
          "\n"
          "nothing is imported; --skip-bad imports the {}",
          Counted(materials.size(), "valid glass", "valid glasses"));
    }
    return tl::unexpected(std::move(all));
  }
  if (!flags.as.empty()) {
    if (materials.size() != 1) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--as is the name of one glass, but the files have {}; "
                              "import them without it",
                              materials.size()),
                  flags.as);
    }
    materials.front().name = flags.as;
  }
  INTAGLIO_TRY(store.Import(materials, flags.replace));
  for (const Error& error : errors) std::cerr << "skipped: " << error.message << "\n";
  for (const Material& material : materials) std::cout << material.name << "\n";
  return {};
}

Status Export(const Flags& flags, MaterialStore& store) {
  std::vector<Material> materials;
  if (flags.name.empty()) {
    auto all = INTAGLIO_TRY(store.List());
    materials = std::move(all);
  } else {
    auto one = INTAGLIO_TRY(store.Find(flags.name));
    materials.push_back(std::move(one));
  }
  const std::string yaml = materials_db::ExportRii(materials);
  if (!flags.out.empty()) return io::WriteFileAtomically(flags.out, yaml);
  std::cout << yaml;
  return {};
}

// ---- The command line ----------------------------------------------------------

void AddFieldFlags(command_line::Command command, Flags& flags) {
  command.AddOption("--manufacturer", flags.manufacturer, "manufacturer");
  command.AddOption("--source", flags.source, "source of the values");
  command.AddOption("--formula", flags.formula,
                    "dispersion formula, e.g. sellmeier_1, schott, rii_formula_2");
  command.AddOption("--coefficients", flags.coefficients,
                    "coefficients of the formula, in the order of its catalog");
  command.AddOption("--range", flags.range_um, "range of valid wavelengths, um: MIN MAX")
      .TakeValues(2);
  for (const PropertyRow& row : PropertyRows()) {
    std::string flag = fmt::format("--{}", row.name);
    std::replace(flag.begin(), flag.end(), '_', '-');
    command.AddOption(flag, flags.properties.*row.value,
                      fmt::format("{}, {}{}{:g} to {:g}", row.title, row.unit,
                                  *row.unit == '\0' ? "" : ", ", row.min, row.max));
  }
}

int Run(const Flags& flags, Action action) {
  auto store = MaterialStore::Open(materials_db::DatabasePathOf(flags.database));
  if (!store) return Complain(store.error());
  const Status status = action(flags, *store);
  return status ? client::kExitGood : Complain(status.error());
}

}  // namespace

void AddMaterialsCommand(command_line::Command app) {
  auto flags = std::make_shared<Flags>();
  command_line::Command materials =
      app.AddCommand("materials", "manage the known glasses");
  materials.RequireCommand();
  materials.SetFooter(
      "Example: intaglio materials list; then intaglio materials show N-BK7\n"
      "docs/materials.md has an example of each.");
  materials.AddOption("--db", flags->database,
                      "material base, default $INTAGLIO_MATERIALS_DB or the user's");
  const auto add = [&](const char* name, const char* text, Action action) {
    command_line::Command command = materials.AddCommand(name, text);
    command.TakeOptionsOfParent();
    command.SetAction([flags, action] { return Run(*flags, action); });
    return command;
  };

  const auto add_wavelength = [&](command_line::Command command) {
    command.AddOption("--wavelength", flags->wavelength_nm,
                      "nm, default that of the machine");
    command
        .AddOption("--machine", flags->machine,
                   "machine profile whose laser and lens count: a name, or a file")
        .ShowDefault();
  };
  const auto add_json = [&](command_line::Command command) {
    command.AddFlag("--json", flags->json, "for programs, as in report.json");
  };
  command_line::Command list = add("list", "list all glasses, one a line", List);
  add_wavelength(list);
  add_json(list);

  command_line::Command show = add("show", "show one glass and its optical values", Show);
  show.AddOption("NAME", flags->name, "the glass").Require();
  add_wavelength(show);
  show.AddOption("--focal", flags->focal_mm,
                 "focal length of the lens, mm, default the machine's mounted lens");
  show.AddOption("--na", flags->numerical_aperture,
                 "numerical aperture in air, default that of the lens");
  add_json(show);

  command_line::Command add_glass = add("add", "add a glass with these values", Add);
  add_glass.AddOption("NAME", flags->name, "its name").Require();
  AddFieldFlags(add_glass, *flags);
  for (const char* needed : {"--formula", "--coefficients", "--range"}) {
    add_glass.OptionOf(needed).Require();
  }

  command_line::Command replace = add("replace", "change values of a glass", Replace);
  replace.AddOption("NAME", flags->name, "the glass").Require();
  replace.AddOption("--from", flags->from,
                    "take all values from this file, as for import");
  AddFieldFlags(replace, *flags);

  add("remove", "remove a glass", Remove)
      .AddOption("NAME", flags->name, "the glass")
      .Require();

  command_line::Command import = add("import", "import glasses from files", Import);
  import
      .AddOption("FILE", flags->files,
                 "glass catalogs (.agf), refractiveindex.info records (.yml)")
      .Require();
  import.AddOption("--as", flags->as, "the name of the one glass in the file");
  import.AddFlag("--replace", flags->replace, "replace existing glasses");
  import.AddFlag("--skip-bad", flags->skip_bad,
                 "import the valid glasses of a file, even if others have mistakes");

  command_line::Command export_ =
      add("export", "export as refractiveindex.info records (YAML)", Export);
  export_.AddOption("NAME", flags->name, "one glass, default all");
  export_.AddOption("--out", flags->out, "file, default the standard output");
}

}  // namespace intaglio::cli
