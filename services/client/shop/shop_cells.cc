#include "services/client/shop/shop_cells.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/core/try.h"

namespace intaglio::client {

std::vector<MachineSpec> CopiesOf(const MachineSpec& machine, int count) {
  std::vector<MachineSpec> copies = {machine};
  for (int number = 2; number <= count; ++number) {
    copies.push_back(machine);
    copies.back().set_name(fmt::format("{}-{}", machine.name(), number));
  }
  return copies;
}

ServiceSetOptions OptionsOfCell(const ServiceSetOptions& shop,
                                const MachineSpec& machine) {
  ServiceSetOptions cell = shop;
  cell.folder = shop.folder / kCellsFolder / machine.name();
  cell.machine = WithKeptTaught(cell.folder, machine);
  cell.bus.cell = machine.name();
  cell.without.insert({"job-service", "discretizer", "sorter"});
  cell.recording.clear();
  cell.console = {};
  return cell;
}

Error NamedAt(const std::string& cell, Error error) {
  const bool is_named = error.message.starts_with(cell) &&
                        (error.message.compare(cell.size(), 1, " ") == 0 ||
                         error.message.compare(cell.size(), 1, ":") == 0);
  if (!is_named) error.message = cell + ": " + error.message;
  return error;
}

Error ShopCells::NamedIn(std::size_t cell, Error error) const {
  return cell == 0 ? error : NamedAt(sets_[cell].machine().name(), std::move(error));
}

Result<ShopCells> ShopCells::Start(const std::vector<Cell>& cells) {
  ShopCells shop;
  for (const Cell& cell : cells) {
    auto set = ServiceSet::Start(cell.options,
                                 cell.virtual_machine ? &*cell.virtual_machine : nullptr);
    if (!set) {
      Error error = std::move(set.error());
      if (!shop.sets_.empty())
        error = NamedAt(cell.options.machine.name(), std::move(error));
      shop.Stop();
      return tl::unexpected(std::move(error));
    }
    shop.sets_.push_back(std::move(*set));
  }
  return shop;
}

Status ShopCells::AwaitReady(JobClient& client) {
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    if (auto ready = sets_[i].AwaitReady(client); !ready)
      return tl::unexpected(NamedIn(i, std::move(ready.error())));
  }
  return {};
}

Result<std::vector<std::string>> ShopCells::Revive() {
  std::vector<std::string> revived;
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    auto of_cell = sets_[i].Revive();
    if (!of_cell) return tl::unexpected(NamedIn(i, std::move(of_cell.error())));
    const std::string prefix = i > 0 ? sets_[i].machine().name() + ": " : "";
    for (const std::string& sentence : *of_cell) revived.push_back(prefix + sentence);
  }
  return revived;
}

void ShopCells::Stop() {
  for (std::size_t i = 1; i < sets_.size(); ++i) sets_[i].Terminate();
  for (std::size_t i = 1; i < sets_.size(); ++i) sets_[i].Stop();
  if (!sets_.empty()) sets_.front().Stop();
  sets_.clear();
}

std::vector<std::string> ShopCells::Processes() {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    const std::string of_cell =
        i > 0 ? fmt::format(" ({})", sets_[i].machine().name()) : "";
    for (const std::string& line : sets_[i].Processes()) lines.push_back(line + of_cell);
  }
  return lines;
}

std::vector<std::filesystem::path> ShopCells::machine_files() const {
  std::vector<std::filesystem::path> files;
  for (const ServiceSet& set : sets_) files.push_back(set.machine_file());
  return files;
}

}  // namespace intaglio::client
