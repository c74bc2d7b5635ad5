#pragma once

// Servers of PostgreSQL for one test: each has its own folder and port on this computer,
// and ends with its holder. As root they run as another user, because the server refuses
// root.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::test {

class PostgresServer {
 public:
  /// `primary`: this one is its copy and follows it, until it is promoted.
  explicit PostgresServer(const PostgresServer* primary = nullptr);
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  /// False: Debian's package postgresql is not installed here, and the test is skipped.
  static bool IsInstalled();
  /// Why it does not run; empty when it does.
  const std::string& error() const { return error_; }
  /// postgresql://... of its database.
  std::string address() const;
  /// The same with the host of another one behind it.
  std::string AddressWith(const PostgresServer& other) const;

  void Start();
  void Kill();  ///< SIGKILL, to it and its children
  /// Ends every session, as a restart of the server does.
  void EndSessions();
  /// Makes it anew, as a copy that follows this one; it does not run before.
  void Follow(const PostgresServer& primary);
  /// A copy becomes a primary.
  void Promote();
  /// From now on a commit waits until the copy has it; returns when the copy follows.
  void WaitForItsCopy();

 private:
  std::filesystem::path data() const { return folder_ / "data"; }
  /// A program of the server's package, awaited; an error when it fails.
  void RunToTheEnd(const char* program, const std::vector<std::string>& arguments);
  int RunProgram(const std::string& program, const std::vector<std::string>& arguments,
                 bool wait);
  bool Answers();

  std::filesystem::path folder_;
  int port_ = 0, pid_ = -1;
  std::string error_;
};

}  // namespace intaglio::test
