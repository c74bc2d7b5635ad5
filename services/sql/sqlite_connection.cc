#include "services/sql/sqlite_connection.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace intaglio::sql {
namespace {

constexpr int kBusyMs = 2000;

template <typename Body>
auto Guarded(Body&& body) {
  try {
    return body();
  } catch (const SQLite::Exception& error) {
    throw SqlError(KindOfSqlite(error.getErrorCode()), error.what());
  }
}

class SqliteStatement final : public Statement {
 public:
  SqliteStatement(SQLite::Database& database, const std::string& sql)
      : statement_(Guarded([&] { return SQLite::Statement(database, sql); })) {}

  void BindBytes(int place, std::string_view bytes) override {
    Guarded(
        [&] { statement_.bind(place, bytes.data(), static_cast<int>(bytes.size())); });
  }
  bool Step() override {
    return Guarded([this] { return statement_.executeStep(); });
  }
  int Execute() override {
    return Guarded([this] { return statement_.exec(); });
  }
  void Reset() override {
    Guarded([this] { statement_.reset(); });
  }
  int ColumnOf(std::string_view name) override {
    return Guarded([&] { return statement_.getColumnIndex(std::string(name).c_str()); });
  }
  bool IsNull(int column) override { return Column(column).isNull(); }
  std::int64_t Integer(int column) override { return Column(column).getInt64(); }
  double Real(int column) override { return Column(column).getDouble(); }
  std::string Text(int column) override { return Column(column).getString(); }

 private:
  SQLite::Column Column(int column) {
    return Guarded([&] { return statement_.getColumn(column); });
  }
  void BindInteger(int place, std::int64_t value) override {
    Guarded([&] { statement_.bind(place, value); });
  }
  void BindReal(int place, double value) override {
    Guarded([&] { statement_.bind(place, value); });
  }
  void BindText(int place, std::string_view text) override {
    Guarded([&] { statement_.bind(place, std::string(text)); });
  }

  SQLite::Statement statement_;
};

class SqliteConnection final : public Connection {
 public:
  SqliteConnection(const std::filesystem::path& file, int flags)
      : database_(
            Guarded([&] { return SQLite::Database(file.string(), flags, kBusyMs); })) {}

  ~SqliteConnection() override {
    if (note_file_ >= 0) close(note_file_);
  }
  SqliteConnection(const SqliteConnection&) = delete;
  SqliteConnection& operator=(const SqliteConnection&) = delete;

  std::unique_ptr<Statement> Prepare(const std::string& sql) override {
    return std::make_unique<SqliteStatement>(database_, sql);
  }
  void Run(const std::string& script) override {
    Guarded([&] { database_.exec(script); });
  }
  int Version() override {
    return static_cast<int>(IntegerOf(*this, "PRAGMA user_version"));
  }
  void SetVersion(int version) override {
    Run(fmt::format("PRAGMA user_version = {}", version));
  }
  bool TryOwn() override { return true; }
  std::string Note() override {
    std::array<char, 192> text{};
    const auto size = pread(NoteFile(), text.data(), text.size(), 0);
    return {text.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
  }
  // A disk that refuses it makes the next absence unknown, no more.
  void KeepNote(const std::string& text) override {
    [[maybe_unused]] const auto written = pwrite(NoteFile(), text.data(), text.size(), 0);
  }
  std::string Place() const override { return database_.getFilename(); }

 private:
  /// Beside the database; -1: it cannot be opened.
  int NoteFile() {
    constexpr mode_t kMode = 0644;
    if (note_file_ < 0)
      note_file_ = open((Place() + ".seen").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
    return note_file_;
  }

  SQLite::Database database_;
  int note_file_ = -1;
};

}  // namespace

SqlError::Kind KindOfSqlite(int result_code) {
  constexpr int kPrimary = 0xff;  // an extended code has it in its lowest byte
  switch (result_code & kPrimary) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      return SqlError::Kind::kDamaged;
    case SQLITE_FULL:
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_NOMEM:
      return SqlError::Kind::kPasses;
    default:
      return SqlError::Kind::kOther;
  }
}

std::unique_ptr<Connection> OpenSqlite(const std::filesystem::path& file) {
  auto connection = std::make_unique<SqliteConnection>(
      file, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  connection->Run("PRAGMA journal_mode = WAL");
  connection->Run("PRAGMA synchronous = FULL");
  connection->Run("PRAGMA foreign_keys = ON");
  return connection;
}

std::unique_ptr<Connection> OpenSqliteToRead(const std::filesystem::path& file) {
  return std::make_unique<SqliteConnection>(file, SQLite::OPEN_READONLY);
}

}  // namespace intaglio::sql
