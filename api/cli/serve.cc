#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "api/cli/command.h"
#include "api/default_model.h"
#include "api/routes.h"
#include "api/server.h"
#include "api/training_service.h"
#include "graph/model_io.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

struct ServeFlags {
  std::vector<std::string> models;
  ServerOptions server;
  std::string data_dir, database;
  std::vector<std::string> page_hosts;
};

/// A folder that goes with the process: for servers that are not told where to keep their jobs.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "morphograph-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("cannot make a temporary folder " + pattern);
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Serves a model file under its own name; under its file's name where the first is taken.
void AddModelFile(const std::string& file, ModelRegistry* models) {
  const std::shared_ptr<const MotionGraph> graph = LoadModel(file);
  const std::string stem = fs::path(file).stem().string();
  if (models->Add(graph->name(), graph) || models->Add(stem, graph)) return;
  throw std::runtime_error(file + ": models named " + graph->name() + " and " + stem + " are served already");
}

bool IsLoopback(const std::string& host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

void Serve(const ServeFlags& flags) {
  if (!flags.database.empty() && !flags.database.starts_with("sqlite:"))
    throw UsageError("--database: only sqlite:PATH is supported, not '" + flags.database + "'");
  Service service;
  for (const std::string& file : flags.models) AddModelFile(file, &service.models);
  if (flags.models.empty()) {
    if (const auto graph = LoadDefaultModel()) service.models.Add(graph->name(), graph);
  }

  std::optional<TemporaryFolder> temporary;
  if (flags.data_dir.empty()) temporary.emplace();
  const int threads = flags.server.threads > 0 ? flags.server.threads
                                               : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  TrainingService training(&service, temporary ? temporary->path() : fs::path(flags.data_dir), flags.database, threads);
  service.training = &training;

  const Router router(AllRoutes(&service));
  ServerOptions options = flags.server;
  options.ready = &service.ready;
  if (IsLoopback(options.host)) {
    options.page_hosts = flags.page_hosts;
    for (const char* name : {"localhost", "127.0.0.1", "[::1]"}) options.page_hosts.emplace_back(name);
    options.page_hosts.push_back(options.host);
  }
  Server server(router, &service.metrics, options);
  server.StopOnSignals();
  const int port = server.Bind();
  const std::string host = flags.server.host.find(':') == std::string::npos ? flags.server.host : "[" + flags.server.host + "]";
  std::cout << "serving on http://" << host << ':' << port << "/\n";
  for (const auto& model : service.models.List()) std::cout << "model " << model->name << ", " << model->graph->hash() << '\n';
  if (service.models.List().empty()) std::cout << "no model yet: train one with POST /v1/models, or give --model\n";
  if (temporary) std::cout << "trained models and jobs end with this process; keep them with --data-dir\n";
  std::cout.flush();
  server.Run();
}

}  // namespace

void AddServe(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<ServeFlags>();
  CLI::App* verb = program->add_subcommand("serve", "Serve models over HTTP");
  verb->add_option("--model", flags->models, "Model files; the embedded model when absent");
  verb->add_option("--host", flags->server.host, "Address to listen on")->capture_default_str();
  verb->add_option("--port", flags->server.port, "Port; 0 takes any free one")->check(CLI::Range(0, 65535))->capture_default_str();
  verb->add_option("--page-host", flags->page_hosts,
                   "Hosts, other than this machine, whose pages may ask for clips: of a proxy in front, when listening on loopback only");
  verb->add_option("--data-dir", flags->data_dir, "Keeps trained models and jobs over restarts");
  verb->add_option("--database", flags->database, "Job database, sqlite:PATH; jobs.db in the data folder when absent");
  verb->add_option("--threads", flags->server.threads, "Workers; 0: one a core")->check(CLI::Range(0, 256))->capture_default_str();
  verb->callback([flags, work] { *work = [flags] { Serve(*flags); }; });
}

}  // namespace morphograph
