#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "graph/graph_summary.h"

namespace morphograph {

/// What is served, without primitives and edges: name, hash, data, styles, provenance, notes.
nlohmann::ordered_json ModelJson(const GraphSummary& summary, const std::string& name);

/// All of it: the model's facts, each primitive, each edge (`inspect --json`, `GET /v1/models/{name}/graph`).
nlohmann::ordered_json GraphJson(const GraphSummary& summary, const std::string& name);

/// What the starts and ends rest on, one entry a primitive: style, name, out of (or into) what, examples, how many of them made.
nlohmann::ordered_json StartsAndEndsJson(const GraphSummary& summary);

/// The graph for Graphviz: a cluster a style, edges labelled with their probability.
std::string GraphDot(const GraphSummary& summary);

/// The same for reading in a terminal.
std::string GraphText(const GraphSummary& summary);

}  // namespace morphograph
