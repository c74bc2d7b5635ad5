#pragma once

// Fixtures of tests that need a server, or that run on both engines of services/sql. A
// test that needs a server is skipped where Debian's package postgresql is not installed;
// a fixture with a SetUp of its own calls this one first and ends where IsReady is false.

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "tests/services/sql/postgres_server.h"
#include "tests/test_folder.h"

namespace intaglio::test {

template <typename Base = testing::Test>
class OnServer : public Base {
 protected:
  void SetUp() override {
    if (!PostgresServer::IsInstalled())
      GTEST_SKIP() << "the package postgresql is not installed";
    server_.emplace();
    ASSERT_EQ(server_->error(), "");
  }
  bool IsReady() const { return server_ && server_->error().empty(); }

  std::optional<PostgresServer> server_;
};

/// For "file" and "server"; `address_` is of services/sql/address.h.
template <typename Base = testing::Test>
class OnEachEngine : public OnServer<Base>,
                     public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    if (IsFile()) {
      address_ = FreshFolder() / "jobs.db";
      return;
    }
    OnServer<Base>::SetUp();
    if (IsReady()) address_ = this->server_->address();
  }
  static bool IsFile() { return std::string(GetParam()) == "file"; }
  bool IsReady() const { return IsFile() || OnServer<Base>::IsReady(); }

  std::string address_;
};

inline auto EachEngine() { return testing::Values("file", "server"); }
inline std::string NameOfEngine(const testing::TestParamInfo<const char*>& row) {
  return row.param;
}

}  // namespace intaglio::test
