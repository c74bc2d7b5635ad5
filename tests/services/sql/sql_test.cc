// The contract of connection.h, for both engines.

#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "services/sql/address.h"
#include "services/sql/postgres_connection.h"
#include "tests/patience.h"
#include "tests/services/sql/engines.h"

namespace intaglio::sql {
namespace {

using testing::HasSubstr;

TEST(SqlDialect, ParametersAreNumberedInTheirOrder) {
  EXPECT_EQ(PostgresStatement("SELECT a FROM t WHERE b = ? AND c = ? AND d = '?'"),
            "SELECT a FROM t WHERE b = $1 AND c = $2 AND d = '?'");
  EXPECT_EQ(PostgresStatement("UPDATE t SET a = ?2 WHERE b = ?1"),
            "UPDATE t SET a = $2 WHERE b = $1");
  EXPECT_EQ(PostgresStatement("instr(lower(a), ?) > 0 AND b = 'instr'"),
            "strpos(lower(a), $1) > 0 AND b = 'instr'");
}

TEST(SqlDialect, TypesOfScriptsAreThoseOfTheServer) {
  EXPECT_EQ(PostgresScript("CREATE TABLE t (a INTEGER, b TEXT, c BLOB DEFAULT x'',\n"
                           "PRAGMA application_id = 1;\n"
                           "x_mm REAL DEFAULT 'REAL');"),
            "CREATE TABLE t (a BIGINT, b TEXT COLLATE \"C\", c BYTEA DEFAULT '',\n"
            "x_mm DOUBLE PRECISION DEFAULT 'REAL');");
}

TEST(SqlDialect, TextsAreWhatTheServerTakes) {
  EXPECT_EQ(ValidUtf8("Łódź 漢 \xf0\x9f\x92\x8e"), "Łódź 漢 \xf0\x9f\x92\x8e");
  EXPECT_EQ(ValidUtf8(std::string_view("a\0b", 3)),
            "a\xef\xbf\xbd"
            "b");
  EXPECT_EQ(ValidUtf8("\xc0\x80"), "\xef\xbf\xbd\xef\xbf\xbd") << "an overlong form";
  EXPECT_EQ(ValidUtf8("\xed\xa0\x80").size(), 9u) << "half of a surrogate pair";
  EXPECT_EQ(ValidUtf8("ab\xe2\x82"), "ab\xef\xbf\xbd\xef\xbf\xbd") << "torn";
}

TEST(SqlAddress, NoPasswordIsPrinted) {
  EXPECT_EQ(WithoutPassword("postgresql://ann:secret@db/shop"),
            "postgresql://ann:***@db/shop");
  EXPECT_EQ(WithoutPassword("postgresql://ann@db:5432/shop"),
            "postgresql://ann@db:5432/shop");
  EXPECT_EQ(WithoutPassword("/var/lib/jobs.db"), "/var/lib/jobs.db");
}

// Every method of a connection, on a file and on a server.
class SqlEngine : public test::OnEachEngine<> {
 protected:
  void SetUp() override {
    OnEachEngine::SetUp();
    if (!IsReady()) return;
    connection_ = Open(address_);
    ASSERT_TRUE(connection_->TryOwn());
  }
  void MakeTable() {
    connection_->Run(
        "CREATE TABLE things (number INTEGER PRIMARY KEY, name TEXT NOT NULL, "
        "size_mm REAL, bytes BLOB NOT NULL DEFAULT x'')");
  }
  void Insert(std::int64_t number, const std::string& name) {
    const auto insert =
        connection_->Prepare("INSERT INTO things (number, name) VALUES (?, ?)");
    insert->Bind(1, number);
    insert->Bind(2, name);
    EXPECT_EQ(insert->Execute(), 1);
  }

  std::unique_ptr<Connection> connection_;
};

TEST_P(SqlEngine, ValuesComeBackAsTheyWere) {
  MakeTable();
  const std::string bytes("\0\1\xff'\\x", 6);
  const auto insert = connection_->Prepare("INSERT INTO things VALUES (?, ?, ?, ?)");
  const std::int64_t numbers[] = {INT64_MIN, -1, 0, INT64_MAX};
  for (const std::int64_t number : numbers) {
    insert->Bind(1, number);
    insert->Bind(2, "Łódź ?1 '; DROP TABLE things");
    insert->Bind(3, 0.1 + static_cast<double>(number % 7));
    insert->BindBytes(4, bytes);
    EXPECT_EQ(insert->Execute(), 1);
    insert->Reset();
  }
  const auto select = connection_->Prepare(
      "SELECT name, number, bytes, size_mm FROM things "
      "ORDER BY number");
  for (const std::int64_t number : numbers) {
    ASSERT_TRUE(select->Step());
    EXPECT_EQ(select->Integer("number"), number);
    EXPECT_EQ(select->Text(0), "Łódź ?1 '; DROP TABLE things");
    EXPECT_EQ(select->Text("bytes"), bytes);
    EXPECT_EQ(select->Real(3), 0.1 + static_cast<double>(number % 7));
    EXPECT_FALSE(select->IsNull(3));
  }
  EXPECT_FALSE(select->Step());
  EXPECT_THROW(select->ColumnOf("nothing"), SqlError);
}

TEST_P(SqlEngine, NullIsSeenAndReadsAsNothing) {
  MakeTable();
  Insert(1, "a");
  const auto select = connection_->Prepare("SELECT size_mm, bytes FROM things");
  ASSERT_TRUE(select->Step());
  EXPECT_TRUE(select->IsNull(0));
  EXPECT_EQ(select->Real(0), 0);
  EXPECT_EQ(select->Text(1), "");
}

TEST_P(SqlEngine, TextsAreComparedByTheirBytes) {
  MakeTable();
  int number = 0;
  for (const char* const name : {"b", "B", "a~", "ab", "é"}) Insert(++number, name);
  const auto select = connection_->Prepare("SELECT name FROM things ORDER BY name");
  std::vector<std::string> names;
  while (select->Step()) names.push_back(select->Text(0));
  EXPECT_THAT(names, testing::ElementsAre("B", "ab", "a~", "b", "é"));
}

TEST_P(SqlEngine, AnUpsertChangesOneRowAndDoNothingNone) {
  MakeTable();
  Insert(1, "a");
  const auto keep = connection_->Prepare(
      "INSERT INTO things (number, name) VALUES (?, ?) ON CONFLICT DO NOTHING");
  keep->Bind(1, 1);
  keep->Bind(2, "b");
  EXPECT_EQ(keep->Execute(), 0);
  const auto change = connection_->Prepare(
      "INSERT INTO things (number, name) VALUES (?, ?) ON CONFLICT (number) DO UPDATE "
      "SET name = things.name || excluded.name");
  change->Bind(1, 1);
  change->Bind(2, "c");
  EXPECT_EQ(change->Execute(), 1);
  const auto select = connection_->Prepare("SELECT name FROM things");
  ASSERT_TRUE(select->Step());
  EXPECT_EQ(select->Text(0), "ac");
}

TEST_P(SqlEngine, ATransactionIsAllOrNothing) {
  MakeTable();
  {
    const Transaction transaction(*connection_);
    Insert(1, "a");
  }
  EXPECT_EQ(IntegerOf(*connection_, "SELECT count(*) FROM things"), 0);
  {
    Transaction transaction(*connection_);
    Insert(1, "a");
    EXPECT_THROW(Insert(1, "b"), SqlError);
  }
  EXPECT_EQ(IntegerOf(*connection_, "SELECT count(*) FROM things"), 0);
  Transaction transaction(*connection_);
  Insert(1, "a");
  transaction.Commit();
  EXPECT_EQ(IntegerOf(*Open(address_), "SELECT count(*) FROM things"), 1);
}

TEST_P(SqlEngine, VersionAndNoteStay) {
  EXPECT_EQ(connection_->Version(), 0);
  connection_->SetVersion(13);
  EXPECT_EQ(connection_->Note(), "");
  connection_->KeepNote("boot 1 2 3\n");
  connection_ = Open(address_);
  EXPECT_EQ(connection_->Version(), 13);
  EXPECT_EQ(connection_->Note(), "boot 1 2 3\n");
  EXPECT_EQ(OpenToRead(address_)->Version(), 13);
}

TEST_P(SqlEngine, APragmaIsForTheEngineThatKnowsIt) {
  EXPECT_NO_THROW(connection_->Run("\nPRAGMA application_id = 7;\n"));
}

TEST_P(SqlEngine, AWrongStatementIsAnErrorThatDoesNotPass) {
  try {
    connection_->Run("INSERT INTO nowhere VALUES (1)");
    FAIL();
  } catch (const SqlError& error) {
    EXPECT_EQ(error.kind(), SqlError::Kind::kOther);
    EXPECT_THAT(error.what(), HasSubstr("nowhere"));
  }
  EXPECT_NO_THROW(connection_->Run("CREATE TABLE after_it (a INTEGER)"));
}

INSTANTIATE_TEST_SUITE_P(Engines, SqlEngine, test::EachEngine(), test::NameOfEngine);

class SqlServer : public test::OnServer<> {};

TEST_F(SqlServer, OneConnectionOwnsTheStoreUntilItEnds) {
  auto first = OpenPostgres(server_->address());
  const auto second = OpenPostgres(server_->address());
  EXPECT_TRUE(first->TryOwn());
  EXPECT_FALSE(second->TryOwn());
  first.reset();
  // The server ends a session a moment later.
  EXPECT_TRUE(test::Eventually([&] { return second->TryOwn(); }));
}

TEST_F(SqlServer, WhatAnswersNoMoreIsAnErrorThatPasses) {
  const auto connection = OpenPostgres(server_->address());
  server_->Kill();
  for (const bool again : {false, true}) {
    try {
      // The first statement may still be answered by a session that is being ended.
      for (int i = 0; i < 50; ++i) {
        again ? (void)OpenPostgres(server_->address()) : connection->Run("SELECT 1");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
      FAIL();
    } catch (const SqlError& error) {
      EXPECT_EQ(error.kind(), SqlError::Kind::kPasses) << error.what();
    }
  }
}

}  // namespace
}  // namespace intaglio::sql
