#include "api/request/output_reader.h"

#include "api/request/object_reader.h"

namespace morphograph {

OutputFormat ReadOutputFormat(const nlohmann::json& object, Findings* findings) {
  OutputFormat output;
  ObjectReader reader(object, "/output", findings);
  output.frame_rate_hz = reader.Finite("frame_rate");
  if (const auto channels = reader.Text("channels")) {
    if (*channels == "portable") {
      output.channels = OutputChannels::kPortable;
    } else if (*channels == "source") {
      output.channels = OutputChannels::kSource;
    } else {
      findings->Malformed("/output/channels", "must be \"portable\" or \"source\"");
    }
  }
  if (const auto unit = reader.Text("unit")) {
    if (*unit == "source") {
      output.unit = OutputUnit::kSource;
    } else if (*unit == "m") {
      output.unit = OutputUnit::kMetre;
    } else if (*unit == "cm") {
      output.unit = OutputUnit::kCentimetre;
    } else {
      findings->Malformed("/output/unit", "must be \"m\", \"cm\" or \"source\"");
    }
  }
  reader.RefuseOthers();
  return output;
}

}  // namespace morphograph
