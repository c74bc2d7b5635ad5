#pragma once

// A relational database as a shop's queue needs it, written once for two engines: a file
// of this computer (SQLite, sqlite_connection.h) and a server that several computers
// reach (PostgreSQL, postgres_connection.h). Statements are written in the words that
// both understand:
//
//   parameters    ? in their order, or ?1, ?2, ...
//   functions     coalesce, count, instr (where a text has another one), lower, max
//   upsert        INSERT ... ON CONFLICT (...) DO UPDATE or DO NOTHING
//   script        types INTEGER (64 bits), REAL (double), TEXT (compared by its bytes),
//                 BLOB, and x'' for an empty one; PRAGMA is obeyed by SQLite alone
//
// Times are texts (host::UtcText), computed by the caller. Everything throws SqlError, is
// used from one thread, and returns when the change is durable.

#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace intaglio::sql {

class SqlError : public std::runtime_error {
 public:
  enum class Kind {
    kDamaged,  ///< what was stored cannot be read
    kPasses,   ///< waiting may cure it: a full disk, a server that restarts
    kOther,
  };
  SqlError(Kind kind, const std::string& what) : std::runtime_error(what), kind_(kind) {}
  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

/// One prepared statement. Places of parameters count from 1, columns from 0.
class Statement {
 public:
  virtual ~Statement() = default;

  template <std::integral T>
  void Bind(int place, T value) {
    BindInteger(place, static_cast<std::int64_t>(value));
  }
  void Bind(int place, double value) { BindReal(place, value); }
  void Bind(int place, std::string_view text) { BindText(place, text); }
  void Bind(int place, const char* text) { BindText(place, text); }
  virtual void BindBytes(int place, std::string_view bytes) = 0;

  /// The next row; false: there is none.
  virtual bool Step() = 0;
  /// Runs a statement that gives no rows; returns how many it has changed.
  virtual int Execute() = 0;
  /// For new parameters; the old ones stay until they are replaced.
  virtual void Reset() = 0;

  /// The column of this name in the rows.
  virtual int ColumnOf(std::string_view name) = 0;
  virtual bool IsNull(int column) = 0;
  virtual std::int64_t Integer(int column) = 0;
  virtual double Real(int column) = 0;
  /// A text, or bytes as they are.
  virtual std::string Text(int column) = 0;
  std::int64_t Integer(std::string_view name) { return Integer(ColumnOf(name)); }
  double Real(std::string_view name) { return Real(ColumnOf(name)); }
  std::string Text(std::string_view name) { return Text(ColumnOf(name)); }

 private:
  virtual void BindInteger(int place, std::int64_t value) = 0;
  virtual void BindReal(int place, double value) = 0;
  virtual void BindText(int place, std::string_view text) = 0;
};

class Connection {
 public:
  virtual ~Connection() = default;

  virtual std::unique_ptr<Statement> Prepare(const std::string& sql) = 0;
  /// Statements without parameters, of the dialect of scripts.
  virtual void Run(const std::string& script) = 0;

  /// The version of the tables; 0: there are none.
  virtual int Version() = 0;
  virtual void SetVersion(int version) = 0;

  /// Takes the store for this process, until the connection ends in whatever way: what
  /// precedes every write. False: another process has it. A file has one job service by
  /// other means (host::OnlyInstance): always true.
  virtual bool TryOwn() = 0;

  /// A line of text beside the tables, which is not durable: written once a second.
  virtual std::string Note() = 0;
  virtual void KeepNote(const std::string& text) = 0;

  /// For messages, without a password.
  virtual std::string Place() const = 0;
};

/// Everything between its construction and Commit, or nothing.
class Transaction {
 public:
  explicit Transaction(Connection& connection) : connection_(connection) {
    connection_.Run("BEGIN");
  }
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit();

 private:
  Connection& connection_;
  bool committed_ = false;
};

/// The first column of the only row of a statement without parameters.
std::int64_t IntegerOf(Connection& connection, const std::string& sql);

}  // namespace intaglio::sql
