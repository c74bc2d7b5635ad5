#include "services/job_service/permission_keeper.h"

#include <gmock/gmock.h>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::job_service {
namespace {

class PermissionKeeperTest : public testing::Test {
 protected:
  std::set<std::string> OpenCells() {
    std::set<std::string> cells;
    for (const auto& [cell, pressed] : keeper_.TakeStops()) cells.insert(cell);
    return cells;
  }
  static std::string Cell(std::size_t i) { return "cell" + std::to_string(i); }

  bus::Bus bus_{test::PrivateBusOptions()};
  PermissionKeeper keeper_{bus_};
};

TEST_F(PermissionKeeperTest, OfMoreCellsThanAShopHasTheUnusedAreClosed) {
  const std::set<std::string> in_use = {Cell(0), Cell(1)};
  for (std::size_t i = 0; i < PermissionKeeper::kMaxCells; ++i) {
    keeper_.Open(Cell(i), in_use);
  }
  keeper_.Open(Cell(2), in_use);  // has a new job
  EXPECT_EQ(OpenCells().size(), PermissionKeeper::kMaxCells);
  keeper_.Open("another", in_use);
  const auto cells = OpenCells();
  EXPECT_EQ(cells.size(), PermissionKeeper::kMaxCells);
  for (const std::string& open : {Cell(0), Cell(1), Cell(2), std::string("another")}) {
    EXPECT_TRUE(cells.contains(open)) << open;
  }
  EXPECT_FALSE(cells.contains(Cell(3)));
}

TEST_F(PermissionKeeperTest, ACellWhoseStopIsPressedIsNeverClosed) {
  keeper_.Open(Cell(0), {});
  bus::Writer<intaglio_EmergencyStop> stops(bus_, bus::kEmergencyStop, Cell(0));
  const std::string cell = Cell(0), text = "ann";
  intaglio_EmergencyStop press{};
  press.cell = bus::Borrow(cell);
  press.pressed = true;
  press.source = press.operator_name = press.reason = bus::Borrow(text);
  press.number = 1;
  ASSERT_TRUE(test::Eventually([&] {
    EXPECT_TRUE(stops.Write(press));
    return keeper_.TakeStops().at(0).second;
  }));
  for (std::size_t i = 1; i < 2 * PermissionKeeper::kMaxCells; ++i) {
    keeper_.Open(Cell(i), {});
  }
  EXPECT_TRUE(OpenCells().contains(Cell(0)));
  EXPECT_EQ(OpenCells().size(), PermissionKeeper::kMaxCells);
}

TEST_F(PermissionKeeperTest, CellsThatAreInUseStayOpenHoweverManyThereAre) {
  std::set<std::string> in_use;
  for (std::size_t i = 0; i < PermissionKeeper::kMaxCells + 3; ++i) {
    in_use.insert(Cell(i));
    keeper_.Open(Cell(i), in_use);
  }
  EXPECT_EQ(OpenCells(), in_use);
}

}  // namespace
}  // namespace intaglio::job_service
