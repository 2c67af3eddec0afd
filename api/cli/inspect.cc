#include <iostream>
#include <memory>

#include "api/cli/command.h"
#include "api/model_description.h"
#include "graph/model_io.h"

namespace morphograph {
namespace {

struct InspectFlags {
  std::string model;
  bool json = false;
  bool dot = false;
};

void Inspect(const InspectFlags& flags) {
  const GraphSummary summary = Summarise(*LoadModel(flags.model));
  if (flags.json) {
    std::cout << GraphJson(summary, summary.name).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
              << '\n';
  } else {
    std::cout << (flags.dot ? GraphDot(summary) : GraphText(summary));
  }
}

}  // namespace

void AddInspect(CLI::App* program, Work* work) {
  const auto flags = std::make_shared<InspectFlags>();
  CLI::App* verb = program->add_subcommand("inspect", "Tell what a model holds");
  verb->add_option("model", flags->model, "Model file")->required();
  CLI::Option* json = verb->add_flag("--json", flags->json, "As JSON");
  verb->add_flag("--dot", flags->dot, "The graph for Graphviz")->excludes(json);
  verb->callback([flags, work] { *work = [flags] { Inspect(*flags); }; });
}

}  // namespace morphograph
