#pragma once

// The processes of a shop with several machines on one computer: the services of the
// shop and the first machine's cell are one ServiceSet, the cell of each further machine
// is another one without job service, discretizer and sorter. The folder of a further
// cell is cells/NAME in that of the shop.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/client/shop/service_set.h"

namespace intaglio::client {

/// In the folder of a shop: the folders of its further cells.
inline constexpr char kCellsFolder[] = "cells";

/// `count` profiles with the names NAME, NAME-2, NAME-3 ... that are alike otherwise.
/// `count`: from 1 on.
std::vector<MachineSpec> CopiesOf(const MachineSpec& machine, int count);

/// The cell of a further machine of the shop has its own folder, and no services of
/// the shop, no recorder and no console.
ServiceSetOptions OptionsOfCell(const ServiceSetOptions& shop,
                                const MachineSpec& machine);

/// `error` with the name of its machine at the beginning, once: an error that begins with
/// the name of the machine stays as it is.
Error NamedAt(const std::string& cell, Error error);

class ShopCells {
 public:
  struct Cell {
    ServiceSetOptions options;
    std::optional<VirtualMachine> virtual_machine;
  };

  /// Starts everything; the first cell has the services of the shop. On failure what was
  /// started is ended again. An error of a further cell begins with its name.
  static Result<ShopCells> Start(const std::vector<Cell>& cells);

  /// As those of ServiceSet, over all cells. What concerns a further cell names it.
  Status AwaitReady(JobClient& client);
  Result<std::string> AwaitConsole() { return sets_.front().AwaitConsole(); }
  Result<std::vector<std::string>> Revive();
  /// The further cells first, while the job service still takes what they report.
  void Stop();
  std::vector<std::string> Processes();

  /// The profiles as the cells use them, in the order of the cells.
  std::vector<std::filesystem::path> machine_files() const;

 private:
  Error NamedIn(std::size_t cell, Error error) const;

  std::vector<ServiceSet> sets_;
};

}  // namespace intaglio::client
