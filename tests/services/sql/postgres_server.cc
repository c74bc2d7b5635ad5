#include "tests/services/sql/postgres_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

#include "services/sql/postgres_connection.h"
#include "tests/patience.h"

namespace intaglio::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr uid_t kNobody = 65534;
constexpr const char* kCopy = "copy";
constexpr auto kPatience = 60s;

/// Where Debian has the programs of the newest version; empty: nowhere.
fs::path Programs() {
  fs::path newest;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/usr/lib/postgresql", error)) {
    const fs::path bin = entry.path() / "bin";
    if (fs::exists(bin / "initdb") && bin > newest) newest = bin;
  }
  return newest;
}

int FreePort() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  bind(fd, reinterpret_cast<sockaddr*>(&address), size);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  close(fd);
  return ntohs(address.sin_port);
}

/// The number of the segment that the server has written: behind its key, in the seventh
/// line.
std::optional<int> SegmentOf(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  for (int i = 0; i < 7; ++i) std::getline(in, line);
  std::istringstream numbers(line);
  long key = 0;
  int segment = -1;
  if (numbers >> key >> segment) return segment;
  return std::nullopt;
}

}  // namespace

bool PostgresServer::IsInstalled() { return !Programs().empty(); }

PostgresServer::PostgresServer(const PostgresServer* primary) : port_(FreePort()) {
  std::string name = (fs::temp_directory_path() / "intaglio-sql-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    error_ = "no temporary folder";
    return;
  }
  folder_ = name;
  if (geteuid() == 0 && chown(name.c_str(), kNobody, kNobody) != 0) error_ = "chown";
  if (primary != nullptr) {
    Follow(*primary);
    return;
  }
  RunToTheEnd("initdb", {"-D", data().string(), "-U", "intaglio", "-A", "trust", "-E",
                         "UTF8", "--locale=C", "--no-sync", "--no-instructions"});
  if (error_.empty()) Start();
}

void PostgresServer::RunToTheEnd(const char* program,
                                 const std::vector<std::string>& arguments) {
  const int code = RunProgram((Programs() / program).string(), arguments, true);
  if (code != 0) error_ = fmt::format("{} ended with {}", program, code);
}

// A server that is killed leaves its segment of shared memory, which the next one of the
// same folder would remove: there is none.
PostgresServer::~PostgresServer() {
  const std::optional<int> segment = SegmentOf(data() / "postmaster.pid");
  Kill();
  if (segment) shmctl(*segment, IPC_RMID, nullptr);
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

std::string PostgresServer::AddressWith(const PostgresServer& other) const {
  return fmt::format("postgresql://intaglio@127.0.0.1:{},127.0.0.1:{}/postgres", port_,
                     other.port_);
}

std::string PostgresServer::address() const {
  return fmt::format("postgresql://intaglio@127.0.0.1:{}/postgres", port_);
}

int PostgresServer::RunProgram(const std::string& program,
                               const std::vector<std::string>& arguments, bool wait) {
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string log = (folder_ / "log").string();
  const pid_t child = fork();
  if (child == 0) {
    setpgid(0, 0);
    if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(126);
    prctl(PR_SET_PDEATHSIG, SIGQUIT);
    const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    if (chdir("/") == 0) execv(argv[0], argv.data());
    _exit(127);
  }
  if (!wait) {
    pid_ = child;
    return 0;
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

bool PostgresServer::Answers() {
  return RunProgram((Programs() / "pg_isready").string(),
                    {"-h", "127.0.0.1", "-p", std::to_string(port_)}, true) == 0;
}

void PostgresServer::Start() {
  RunProgram((Programs() / "postgres").string(),
             {"-D", data().string(), "-h", "127.0.0.1", "-p", std::to_string(port_), "-k",
              "", "-F",
              // Files of its own folder, in place of some in /dev/shm that stay.
              "-c", "dynamic_shared_memory_type=mmap"},
             false);
  const test::Patience patience(kPatience);
  while (!Answers()) {
    if (patience.over()) {
      error_ = "the server does not answer";
      return;
    }
    std::this_thread::sleep_for(50ms);
  }
}

void PostgresServer::Kill() {
  if (pid_ <= 0) return;
  kill(-pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void PostgresServer::EndSessions() {
  const auto connection = sql::OpenPostgres(address());
  const auto end = connection->Prepare(
      "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity "
      "WHERE pid <> pg_backend_pid() AND application_name = 'intaglio'");
  end->Step();
}

// The segment of shared memory of the killed one goes with its folder, as in the end.
void PostgresServer::Follow(const PostgresServer& primary) {
  if (const auto segment = SegmentOf(data() / "postmaster.pid"))
    shmctl(*segment, IPC_RMID, nullptr);
  fs::remove_all(data());
  RunToTheEnd("pg_basebackup",
              {"-d",
               fmt::format("host=127.0.0.1 port={} user=intaglio application_name={}",
                           primary.port_, kCopy),
               "-D", data().string(), "-R", "-X", "stream", "-c", "fast", "--no-sync"});
  if (!error_.empty()) return;
  // The copy has the settings of its primary, which has another copy than itself.
  std::ofstream(data() / "postgresql.conf", std::ios::app)
      << "synchronous_standby_names = ''\n";
  Start();
}

void PostgresServer::Promote() {
  RunToTheEnd("pg_ctl", {"promote", "-D", data().string(), "-w"});
}

void PostgresServer::WaitForItsCopy() {
  std::ofstream(data() / "postgresql.conf", std::ios::app)
      << "synchronous_standby_names = '" << kCopy << "'\n";
  kill(pid_, SIGHUP);
  const auto connection = sql::OpenPostgres(address());
  const test::Patience patience(kPatience);
  for (bool follows = false; !follows && !patience.over();) {
    std::this_thread::sleep_for(50ms);
    follows =
        sql::IntegerOf(*connection,
                       "SELECT count(*) FROM pg_stat_replication WHERE sync_state = "
                       "'sync'") > 0;
  }
  if (patience.over()) error_ = "no copy follows";
}

}  // namespace intaglio::test
