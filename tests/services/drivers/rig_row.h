#pragma once

// The rigs of the families of controllers. Each family states its own rows beside its
// rigs, so that the checks of every driver find them:
//
//   const RigRow<MotionRig> kIsel{"isel", "isel", &MakeIselMotionRig};
//
// A program that lists `every_rig` in CMake has the rows of all families.

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::drivers {

template <typename Rig>
class RigRow {
 public:
  /// `serial_number`: in its profile; empty: the one of the controller.
  using Maker = std::unique_ptr<Rig> (*)(const std::string& name,
                                         const std::string& serial_number);

  /// `protocol`: of the row in the table of drivers. `name`: unlike all other rigs'.
  RigRow(std::string protocol, std::string name, Maker make) {
    Rows().push_back({std::move(protocol), std::move(name), make});
  }

  /// In alphabetical order. Empty: no family has stated one.
  static std::vector<std::string> NamesOf(std::string_view protocol) {
    std::vector<std::string> names;
    for (const Row& row : Rows())
      if (row.protocol == protocol) names.push_back(row.name);
    std::ranges::sort(names);
    return names;
  }

  /// Null: there is none of this name.
  static std::unique_ptr<Rig> Make(std::string_view name,
                                   const std::string& serial_number) {
    const auto row = std::ranges::find(Rows(), name, &Row::name);
    return row == Rows().end() ? nullptr : row->make(row->name, serial_number);
  }

 private:
  struct Row {
    std::string protocol, name;
    Maker make;
  };
  static std::vector<Row>& Rows() {
    static std::vector<Row> rows;
    return rows;
  }
};

}  // namespace intaglio::drivers
