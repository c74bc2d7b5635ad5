#include "services/sql/postgres_connection.h"

#include <fmt/format.h>
#include <libpq-fe.h>

#include <array>
#include <charconv>
#include <optional>
#include <vector>

namespace intaglio::sql {
namespace {

// Object identifiers of types (pg_type.dat of the server; they never change).
constexpr Oid kBytea = 17, kInt8 = 20, kText = 25, kFloat8 = 701;
constexpr int kAsText = 0, kAsBinary = 1;

// The number of the advisory lock that the owner of the store has: "INTJ", as in the file
// of SQLite.
constexpr int kOwnerKey = 1229870154;

// A host that is gone is noticed after idle + interval x count seconds of silence, and
// after tcp_user_timeout where something was sent to it ("Database Connection Control
// Functions", parameter key words).
constexpr int kIdleSeconds = 2, kIntervalSeconds = 1, kCount = 3;
static_assert(kIdleSeconds + kIntervalSeconds * kCount == kLostAfterSeconds);

struct Cleared {
  void operator()(PGresult* result) const { PQclear(result); }
  void operator()(PGconn* connection) const { PQfinish(connection); }
};
using Result = std::unique_ptr<PGresult, Cleared>;
using Handle = std::unique_ptr<PGconn, Cleared>;

std::string Trimmed(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

/// By the class of the error ("PostgreSQL Error Codes").
SqlError::Kind KindOf(const Result& result, PGconn* connection) {
  if (PQstatus(connection) != CONNECTION_OK) return SqlError::Kind::kPasses;
  const char* const state = PQresultErrorField(result.get(), PG_DIAG_SQLSTATE);
  const std::string_view text = state == nullptr ? "" : state;
  for (const char* const passes : {"08", "25006", "40", "53", "55", "57", "58"}) {
    if (text.starts_with(passes)) return SqlError::Kind::kPasses;
  }
  return text.starts_with("XX") ? SqlError::Kind::kDamaged : SqlError::Kind::kOther;
}

Result Checked(PGresult* raw, PGconn* connection) {
  Result result(raw);
  const ExecStatusType status = PQresultStatus(result.get());
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK ||
      status == PGRES_EMPTY_QUERY) {
    return result;
  }
  throw SqlError(KindOf(result, connection), Trimmed(PQerrorMessage(connection)));
}

class PostgresStatement final : public Statement {
 public:
  PostgresStatement(PGconn* connection, const std::string& sql)
      : connection_(connection), sql_(sql::PostgresStatement(sql)) {}

  void BindBytes(int place, std::string_view bytes) override {
    ValueAt(place) = {kBytea, kAsBinary, std::string(bytes)};
  }
  bool Step() override {
    if (!result_) Send();
    return ++row_ < PQntuples(result_.get());
  }
  int Execute() override {
    Send();
    int changed = 0;
    const std::string_view count = PQcmdTuples(result_.get());
    std::from_chars(count.data(), count.data() + count.size(), changed);
    return changed;
  }
  void Reset() override { result_.reset(); }

  int ColumnOf(std::string_view name) override {
    const int column = PQfnumber(result_.get(), std::string(name).c_str());
    if (column < 0)
      throw SqlError(SqlError::Kind::kOther, fmt::format("no column '{}'", name));
    return column;
  }
  bool IsNull(int column) override {
    return PQgetisnull(result_.get(), row_, column) != 0;
  }
  std::int64_t Integer(int column) override { return Number<std::int64_t>(column); }
  double Real(int column) override { return Number<double>(column); }
  std::string Text(int column) override {
    const std::string_view text = Field(column);
    if (PQftype(result_.get(), column) != kBytea) return std::string(text);
    std::size_t size = 0;
    unsigned char* const bytes = PQunescapeBytea(
        reinterpret_cast<const unsigned char*>(std::string(text).c_str()), &size);
    if (bytes == nullptr) throw SqlError(SqlError::Kind::kPasses, "no memory");
    std::string out(reinterpret_cast<const char*>(bytes), size);
    PQfreemem(bytes);
    return out;
  }

 private:
  struct Value {
    Oid type = kText;
    int format = kAsText;
    std::optional<std::string> bytes{};
  };
  Value& ValueAt(int place) {
    const auto i = static_cast<std::size_t>(place - 1);
    if (values_.size() <= i) values_.resize(i + 1);
    return values_[i];
  }
  void BindInteger(int place, std::int64_t value) override {
    ValueAt(place) = {kInt8, kAsText, std::to_string(value)};
  }
  void BindReal(int place, double value) override {
    ValueAt(place) = {kFloat8, kAsText, fmt::format("{}", value)};
  }
  void BindText(int place, std::string_view text) override {
    ValueAt(place) = {kText, kAsText, ValidUtf8(text)};
  }

  void Send() {
    std::vector<Oid> types;
    std::vector<const char*> bytes;
    std::vector<int> lengths, formats;
    for (const Value& value : values_) {
      types.push_back(value.type);
      bytes.push_back(value.bytes ? value.bytes->data() : nullptr);
      lengths.push_back(value.bytes ? static_cast<int>(value.bytes->size()) : 0);
      formats.push_back(value.format);
    }
    result_ = Checked(
        PQexecParams(connection_, sql_.c_str(), static_cast<int>(values_.size()),
                     types.data(), bytes.data(), lengths.data(), formats.data(), kAsText),
        connection_);
    row_ = -1;
  }
  std::string_view Field(int column) {
    return {PQgetvalue(result_.get(), row_, column),
            static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
  }
  /// 0 of NULL, as SQLite gives it.
  template <typename T>
  T Number(int column) {
    const std::string_view text = Field(column);
    T value{};
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }

  PGconn* connection_;
  std::string sql_;
  std::vector<Value> values_;
  Result result_;
  int row_ = -1;
};

// Ours come first: what the address says replaces them.
Handle Connected(const std::string& address, const char* session) {
  const std::string idle = std::to_string(kIdleSeconds),
                    interval = std::to_string(kIntervalSeconds),
                    count = std::to_string(kCount),
                    silent_ms = std::to_string(kLostAfterSeconds * 1000);
  const std::array<const char*, 11> keys{"application_name",
                                         "connect_timeout",
                                         "keepalives_idle",
                                         "keepalives_interval",
                                         "keepalives_count",
                                         "tcp_user_timeout",
                                         "client_encoding",
                                         "target_session_attrs",
                                         "options",
                                         "dbname",
                                         nullptr};
  const std::string options = fmt::format(
      "-c tcp_keepalives_idle={} -c tcp_keepalives_interval={} -c "
      "tcp_keepalives_count={} -c tcp_user_timeout={} -c search_path=intaglio -c "
      "client_min_messages=error",
      idle, interval, count, silent_ms);
  const std::array<const char*, 11> values{
      "intaglio",       "5",           idle.c_str(),
      interval.c_str(), count.c_str(), silent_ms.c_str(),
      "UTF8",           session,       options.c_str(),
      address.c_str(),  nullptr};
  Handle handle(PQconnectdbParams(keys.data(), values.data(), 1));
  if (PQstatus(handle.get()) != CONNECTION_OK)
    throw SqlError(SqlError::Kind::kPasses, Trimmed(PQerrorMessage(handle.get())));
  return handle;
}

class PostgresConnection final : public Connection {
 public:
  PostgresConnection(const std::string& address, const char* session)
      : handle_(Connected(address, session)) {}

  std::unique_ptr<Statement> Prepare(const std::string& sql) override {
    return std::make_unique<PostgresStatement>(handle_.get(), sql);
  }
  void Run(const std::string& script) override {
    Checked(PQexec(handle_.get(), PostgresScript(script).c_str()), handle_.get());
  }
  int Version() override {
    const auto table = Prepare("SELECT to_regclass('intaglio.store') IS NULL");
    if (!table->Step() || table->Text(0) != "f") return 0;
    return static_cast<int>(
        IntegerOf(*this, "SELECT coalesce(max(version), 0) FROM store"));
  }
  void SetVersion(int version) override {
    Run(fmt::format("UPDATE store SET version = {}", version));
  }
  bool TryOwn() override {
    const auto lock = Prepare("SELECT pg_try_advisory_lock(?1)");
    lock->Bind(1, kOwnerKey);
    if (!lock->Step() || lock->Text(0) != "t") return false;
    Run("CREATE SCHEMA IF NOT EXISTS intaglio; "
        "CREATE TABLE IF NOT EXISTS store (version INTEGER NOT NULL, note TEXT NOT "
        "NULL); "
        "INSERT INTO store SELECT 0, '' WHERE NOT EXISTS (SELECT 1 FROM store)");
    return true;
  }
  std::string Note() override {
    if (Version() == 0) return {};
    const auto select = Prepare("SELECT note FROM store");
    return select->Step() ? select->Text(0) : std::string();
  }
  void KeepNote(const std::string& text) override {
    Transaction transaction(*this);
    Run("SET LOCAL synchronous_commit = off");
    const auto update = Prepare("UPDATE store SET note = ?");
    update->Bind(1, text);
    update->Execute();
    transaction.Commit();
  }
  std::string Place() const override {
    return fmt::format("postgresql://{}/{}", PQhost(handle_.get()), PQdb(handle_.get()));
  }

 private:
  Handle handle_;
};

}  // namespace

std::unique_ptr<Connection> OpenPostgres(const std::string& address) {
  return std::make_unique<PostgresConnection>(address, "read-write");
}

std::unique_ptr<Connection> OpenPostgresToRead(const std::string& address) {
  return std::make_unique<PostgresConnection>(address, "any");
}

}  // namespace intaglio::sql
