#pragma once

// A server of PostgreSQL for one test: its own folder and port on this computer, ended
// with its holder. As root it runs as another user, because the server refuses root.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::test {

class PostgresServer {
 public:
  PostgresServer();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  /// False: Debian's package postgresql is not installed here, and the test is skipped.
  static bool IsInstalled();
  /// Why it does not run; empty when it does.
  const std::string& error() const { return error_; }
  /// postgresql://... of its database.
  std::string address() const;

  void Start();
  void Kill();  ///< SIGKILL, to it and its children
  /// Ends every session, as a restart of the server does.
  void EndSessions();

 private:
  int RunProgram(const std::string& program, const std::vector<std::string>& arguments,
                 bool wait);
  bool Answers() const;

  std::filesystem::path folder_;
  int port_ = 0, pid_ = -1;
  std::string error_;
};

}  // namespace intaglio::test
