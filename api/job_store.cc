#include "api/job_store.h"

#include <sqlite3.h>

#include <stdexcept>

namespace morphograph {
namespace {

constexpr std::string_view kStateNames[] = {"queued", "running", "succeeded", "failed", "cancelled"};

JobState StateFromName(std::string_view name) {
  for (int i = 0; i < 5; ++i)
    if (kStateNames[i] == name) return static_cast<JobState>(i);
  throw std::runtime_error("the job database holds an unknown state '" + std::string(name) + "'");
}

std::string PathOf(const std::string& url) {
  for (const std::string_view prefix : {"sqlite:///", "sqlite://", "sqlite:"}) {
    if (url.starts_with(prefix)) return (prefix == "sqlite:///" ? "/" : "") + url.substr(prefix.size());
  }
  if (url.find("://") != std::string::npos)
    throw std::invalid_argument("--database: only sqlite:PATH is supported, not '" + url + "'");
  return url;
}

constexpr char kColumns[] = "SELECT id, state, stage, progress, detail, model, action, files, created FROM jobs ";

}  // namespace

std::string_view JobStateName(JobState state) { return kStateNames[static_cast<int>(state)]; }

/// A prepared statement; values are always bound, never pasted into the text.
class JobStore::Statement {
 public:
  Statement(const JobStore& store, const std::string& sql) : store_(store) {
    Check(sqlite3_prepare_v2(store.database_, sql.c_str(), -1, &statement_, nullptr));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& Bind(std::string_view text) {
    Check(sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
    return *this;
  }
  Statement& Bind(double value) {
    Check(sqlite3_bind_double(statement_, ++bound_, value));
    return *this;
  }
  Statement& Bind(int value) {
    Check(sqlite3_bind_int(statement_, ++bound_, value));
    return *this;
  }
  /// True while there is a row.
  bool Step() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) Check(code);
    return false;
  }
  int Integer(int column) const { return sqlite3_column_int(statement_, column); }
  Job ReadJob() const {
    Job job;
    job.id = Text(0);
    job.state = StateFromName(Text(1));
    job.stage = Text(2);
    job.progress = sqlite3_column_double(statement_, 3);
    job.detail = Text(4);
    job.model = Text(5);
    job.action = Text(6);
    job.files = Integer(7);
    job.created = Text(8);
    return job;
  }

 private:
  std::string Text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text ? std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))) : std::string();
  }
  void Check(int code) const {
    if (code != SQLITE_OK)
      throw std::runtime_error(store_.path_ + ": " + sqlite3_errmsg(store_.database_));
  }

  const JobStore& store_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

JobStore::JobStore(const std::string& url) : path_(PathOf(url)) {
  if (sqlite3_open(path_.c_str(), &database_) != SQLITE_OK) {
    const std::string reason = database_ ? sqlite3_errmsg(database_) : "out of memory";
    sqlite3_close(database_);
    throw std::runtime_error("cannot open the job database " + path_ + ": " + reason);
  }
  try {
    sqlite3_busy_timeout(database_, 2000);
    // One server a database: a second one would take the first one's running jobs for left over.
    Execute("PRAGMA locking_mode=EXCLUSIVE");
    Execute("PRAGMA journal_mode=WAL");
    Execute(
        "CREATE TABLE IF NOT EXISTS jobs ("
        "sequence INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, state TEXT NOT NULL, stage TEXT NOT NULL, "
        "progress REAL NOT NULL, detail TEXT NOT NULL, model TEXT NOT NULL, action TEXT NOT NULL, files INTEGER NOT NULL, "
        "created TEXT NOT NULL)");
    Execute("UPDATE jobs SET state='queued', stage='', progress=0 WHERE state='running'");
  } catch (const std::exception&) {
    sqlite3_close(database_);
    throw;
  }
}

JobStore::~JobStore() { sqlite3_close(database_); }

void JobStore::Execute(const char* sql) {
  char* message = nullptr;
  if (sqlite3_exec(database_, sql, nullptr, nullptr, &message) == SQLITE_OK) return;
  const std::string reason = message ? message : sqlite3_errmsg(database_);
  sqlite3_free(message);
  throw std::runtime_error("job database " + path_ + ": " + reason);
}

void JobStore::Insert(const Job& job) {
  const std::lock_guard lock(mutex_);
  Statement statement(*this,
                      "INSERT INTO jobs (id, state, stage, progress, detail, model, action, files, created) "
                      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
  statement.Bind(job.id).Bind(JobStateName(job.state)).Bind(job.stage).Bind(job.progress).Bind(job.detail);
  statement.Bind(job.model).Bind(job.action).Bind(job.files).Bind(job.created).Step();
}

std::optional<Job> JobStore::Find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, std::string(kColumns) + "WHERE id=?");
  statement.Bind(id);
  if (!statement.Step()) return std::nullopt;
  return statement.ReadJob();
}

void JobStore::Update(const Job& job) {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, "UPDATE jobs SET state=?, stage=?, progress=?, detail=? WHERE id=?");
  statement.Bind(JobStateName(job.state)).Bind(job.stage).Bind(job.progress).Bind(job.detail).Bind(job.id).Step();
}

std::optional<Job> JobStore::NextQueued() const {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, std::string(kColumns) + "WHERE state='queued' ORDER BY sequence LIMIT 1");
  if (!statement.Step()) return std::nullopt;
  return statement.ReadJob();
}

int JobStore::Count(JobState state) const {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, "SELECT COUNT(*) FROM jobs WHERE state=?");
  statement.Bind(JobStateName(state)).Step();
  return statement.Integer(0);
}

bool JobStore::IsModelAwaited(const std::string& model) const {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, "SELECT 1 FROM jobs WHERE model=? AND state IN ('queued', 'running')");
  return statement.Bind(model).Step();
}

std::vector<Job> JobStore::List() const {
  const std::lock_guard lock(mutex_);
  Statement statement(*this, std::string(kColumns) + "ORDER BY sequence");
  std::vector<Job> jobs;
  while (statement.Step()) jobs.push_back(statement.ReadJob());
  return jobs;
}

void JobStore::Prune(int kept) {
  const std::lock_guard lock(mutex_);
  Statement statement(*this,
                      "DELETE FROM jobs WHERE state NOT IN ('queued', 'running') AND sequence NOT IN "
                      "(SELECT sequence FROM jobs ORDER BY sequence DESC LIMIT ?)");
  statement.Bind(kept).Step();
}

}  // namespace morphograph
