#include "services/sql/connection.h"

namespace intaglio::sql {

Transaction::~Transaction() {
  if (committed_) return;
  try {
    connection_.Run("ROLLBACK");
  } catch (const SqlError&) {
    // The engine has rolled back already: the error that leads here said why.
  }
}

void Transaction::Commit() {
  connection_.Run("COMMIT");
  committed_ = true;
}

std::int64_t IntegerOf(Connection& connection, const std::string& sql) {
  const auto select = connection.Prepare(sql);
  if (!select->Step()) throw SqlError(SqlError::Kind::kOther, sql + ": it gave no row");
  return select->Integer(0);
}

}  // namespace intaglio::sql
