#include "api/cli/command.h"

namespace morphograph {

void AddPlanned(CLI::App* program, Work* work) {
  for (const std::string name : {"sensors", "markers", "reconstruct"}) {
    CLI::App* verb = program->add_subcommand(name, "(does not exist yet in this version)");
    verb->group("");  // not listed by --help
    verb->allow_extras();
    verb->callback([work, name] {
      *work = [name] { throw UsageError("'" + name + "' does not exist yet in this version"); };
    });
  }
}

}  // namespace morphograph
