#include "api/model_description.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>

namespace morphograph {
namespace {

using nlohmann::ordered_json;

ordered_json PrimitiveJson(const PrimitiveSummary& primitive) {
  const auto start = KeyframeLabelName(primitive.start), end = KeyframeLabelName(primitive.end);
  ordered_json json = {{"name", primitive.name},
                       {"action", primitive.action},
                       {"style", primitive.style},
                       {"styles", ordered_json::array()},
                       {"start", start},
                       {"end", end},
                       {"key_frames", {start, end}},
                       {"examples", primitive.examples},
                       {"made_examples", primitive.made_examples},
                       {"components", primitive.components},
                       {"variance_kept", primitive.variance_kept},
                       {"mixture_size", primitive.mixture_size},
                       {"covariance_form", primitive.covariance_form},
                       {"mean_duration", primitive.mean_duration_s},
                       {"dead_end", primitive.dead_end},
                       {"contacts", ordered_json::array()}};
  if (!primitive.style.empty()) json["styles"].push_back(primitive.style);
  for (const ContactSummary& contact : primitive.contacts) {
    json["contacts"].push_back(
        {{"part", contact.part}, {"from_phase", contact.from_phase}, {"to_phase", contact.to_phase}});
  }
  return json;
}

ordered_json NamesJson(const std::vector<WalkBoundary>& boundaries) {
  ordered_json names = ordered_json::array();
  for (const WalkBoundary boundary : boundaries) names.push_back(WalkBoundaryName(boundary));
  return names;
}

std::string Names(const std::vector<WalkBoundary>& boundaries) {
  std::string names;
  for (const WalkBoundary boundary : boundaries) names += (names.empty() ? "" : ", ") + std::string(WalkBoundaryName(boundary));
  return names;
}

// How a start begins or an end ends, by its outer key frame; nothing for a step inside the walk.
std::optional<WalkBoundary> OuterBoundary(const PrimitiveSummary& primitive) {
  const WalkBoundary start = BoundaryOf(primitive.start), end = BoundaryOf(primitive.end);
  if (start == WalkBoundary::kWalking && end == WalkBoundary::kWalking) return std::nullopt;
  return start != WalkBoundary::kWalking ? start : end;
}

ordered_json EdgeJson(const EdgeSummary& edge) {
  return {{"from", edge.from},
          {"to", edge.to},
          {"pairs", edge.pairs},
          {"probability", edge.probability},
          {"kernel",
           {{"length_scale", edge.length_scale},
            {"signal_variance", edge.signal_variance},
            {"linear_variance", edge.linear_variance},
            {"noise_variance", edge.noise_variance}}},
          {"log_marginal_likelihood", edge.log_marginal_likelihood},
          {"unseen_error", edge.unseen_error}};
}

ordered_json ChangeJson(const ChangeSummary& change) {
  const auto effort = [](const ChangeEffort& of) { return ordered_json{{"speed", of.speed_m_s2}, {"body", of.body_m_s2}}; };
  return {{"name", change.name},
          {"style", change.style},
          {"from_action", change.from_action},
          {"to_action", change.to_action},
          {"from", change.from},
          {"to", change.to},
          {"examples", change.examples},
          {"near_examples", change.near_examples},
          {"least", effort(change.least)},
          {"captured", effort(change.captured)}};
}

// A DOT string: quotes and backslashes escaped.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

template <typename... Values>
std::string Format(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof line, pattern, values...);
  return line;
}

std::string FullName(const PrimitiveSummary& primitive) {
  return primitive.style.empty() ? primitive.name : primitive.style + "/" + primitive.name;
}

}  // namespace

ordered_json ModelJson(const GraphSummary& summary, const std::string& name) {
  ordered_json json = {{"name", name},
                       {"hash", summary.hash},
                       {"action", summary.action},
                       {"actions", ordered_json::array()},
                       {"styles", summary.styles},
                       {"format_version", summary.format_version},
                       {"joints", summary.joints},
                       {"frame_rate", summary.frame_rate_hz},
                       {"metres_per_unit", summary.metres_per_unit},
                       {"clips", summary.clips},
                       {"frames", summary.frames},
                       {"primitive_count", summary.primitives.size()},
                       {"edge_count", summary.edges.size()},
                       {"source", summary.source},
                       {"licence", summary.licence},
                       {"attribution", summary.attribution},
                       {"command", summary.command},
                       {"boundaries", ordered_json::array()},
                       {"notes", summary.notes}};
  for (const ActionSummary& action : summary.actions) {
    json["actions"].push_back({{"name", action.name}, {"styles", action.styles}});
  }
  auto& changes = json["changes"] = ordered_json::array();
  for (const ChangeSummary& change : summary.changes) changes.push_back(ChangeJson(change));
  for (const StyleBoundaries& style : summary.boundaries) {
    json["boundaries"].push_back(
        {{"action", style.action}, {"style", style.style}, {"start_from", NamesJson(style.starts)}, {"end", NamesJson(style.ends)}});
  }
  return json;
}

ordered_json StartsAndEndsJson(const GraphSummary& summary) {
  ordered_json json = ordered_json::array();
  for (const PrimitiveSummary& primitive : summary.primitives) {
    const auto boundary = OuterBoundary(primitive);
    if (!boundary) continue;
    json.push_back({{"action", primitive.action},
                    {"style", primitive.style},
                    {"primitive", primitive.name},
                    {"learned_from", WalkBoundaryName(*boundary)},
                    {"examples", primitive.examples},
                    {"made_examples", primitive.made_examples}});
  }
  return json;
}

ordered_json GraphJson(const GraphSummary& summary, const std::string& name) {
  ordered_json json = ModelJson(summary, name);
  auto& primitives = json["primitives"] = ordered_json::array();
  for (const PrimitiveSummary& primitive : summary.primitives) primitives.push_back(PrimitiveJson(primitive));
  auto& edges = json["edges"] = ordered_json::array();
  for (const EdgeSummary& edge : summary.edges) edges.push_back(EdgeJson(edge));
  return json;
}

std::string GraphDot(const GraphSummary& summary) {
  std::string dot = "digraph " + Quoted(summary.name) + " {\n  node [shape=box, style=rounded];\n";
  std::map<std::string, std::vector<int>> by_style;
  for (int i = 0; i < static_cast<int>(summary.primitives.size()); ++i)
    by_style[summary.primitives[static_cast<std::size_t>(i)].style].push_back(i);
  int cluster = 0;
  for (const auto& [style, members] : by_style) {
    if (!style.empty())
      dot += "  subgraph cluster_" + std::to_string(cluster++) + " {\n  label=" + Quoted(style) + ";\n";
    for (const int i : members) {
      const PrimitiveSummary& primitive = summary.primitives[static_cast<std::size_t>(i)];
      dot += "  p" + std::to_string(i) + " [label=" + Quoted(primitive.name);
      dot += ", tooltip=" + Quoted(std::to_string(primitive.examples) + " examples, " +
                                   std::to_string(primitive.components) + " components") +
             (primitive.dead_end ? ", peripheries=2];\n" : "];\n");
    }
    if (!style.empty()) dot += "  }\n";
  }
  for (const EdgeSummary& edge : summary.edges) {
    dot += "  p" + std::to_string(edge.from) + " -> p" + std::to_string(edge.to) +
           " [label=" + Quoted(Format("%.2f", edge.probability)) +
           ", penwidth=" + Format("%.2f", 0.5 + 2.5 * edge.probability) + "];\n";
  }
  // Made steps, which only walks take that are asked to change.
  for (std::size_t c = 0; c < summary.changes.size(); ++c) {
    const ChangeSummary& change = summary.changes[c];
    const std::string node = "  c" + std::to_string(c);
    dot += node + " [label=" + Quoted(change.name) + ", style=\"rounded,dashed\"];\n";
    for (const EdgeSummary& edge : summary.edges) {
      if (edge.to == change.from) dot += "  p" + std::to_string(edge.from) + " -> c" + std::to_string(c) + " [style=dashed];\n";
      if (edge.from == change.to) dot += node + " -> p" + std::to_string(edge.to) + " [style=dashed];\n";
    }
  }
  return dot + "}\n";
}

std::string GraphText(const GraphSummary& summary) {
  std::string text = "model " + summary.name + ", action " + summary.action;
  for (std::size_t i = 1; i < summary.actions.size(); ++i) text += (i == 1 ? "; also: " : ", ") + summary.actions[i].name;
  text += "\n";
  text += "hash " + summary.hash + ", format " + std::to_string(summary.format_version) + "\n";
  text += "learned from " + std::to_string(summary.clips) + " clips, " + std::to_string(summary.frames) +
          Format(" frames at %.4g Hz; %d joints, unit %.6g m\n", summary.frame_rate_hz, summary.joints,
                 summary.metres_per_unit);
  for (const auto& [label, value] : {std::pair{"source", &summary.source}, std::pair{"licence", &summary.licence},
                                     std::pair{"attribution", &summary.attribution}, std::pair{"command", &summary.command}})
    if (!value->empty()) text += std::string(label) + ": " + *value + "\n";

  for (const StyleBoundaries& style : summary.boundaries)
    text += (style.style.empty() ? "walks" : style.style) + (style.action == summary.action ? "" : " (" + style.action + ")") +
            " can start from: " + Names(style.starts) +
            "; can end in: " + Names(style.ends) + "\n";
  for (const PrimitiveSummary& primitive : summary.primitives) {
    const auto boundary = OuterBoundary(primitive);
    if (!boundary) continue;
    text += FullName(primitive) + (primitive.action == summary.action ? "" : " (" + primitive.action + ")") + " was learned from " + std::string(WalkBoundaryName(*boundary)) + ": " +
            std::to_string(primitive.examples - primitive.made_examples) + " captured and " +
            std::to_string(primitive.made_examples) + " made examples\n";
  }

  std::size_t widest = 9;
  for (const PrimitiveSummary& primitive : summary.primitives) widest = std::max(widest, FullName(primitive).size());
  const int width = static_cast<int>(std::min<std::size_t>(widest, 60));
  text += Format("\n%-*s  %8s %5s %10s %9s %8s %-9s %9s\n", width, "primitive", "examples", "made", "components",
                 "variance", "mixture", "form", "seconds");
  for (const PrimitiveSummary& primitive : summary.primitives) {
    text += Format("%-*.60s  %8d %5d %10d %8.2f%% %8d %-9.9s %9.3f%s\n", width, FullName(primitive).c_str(),
                   primitive.examples, primitive.made_examples, primitive.components, 100 * primitive.variance_kept,
                   primitive.mixture_size, primitive.covariance_form.c_str(), primitive.mean_duration_s,
                   primitive.dead_end ? "  dead end" : "");
    for (const ContactSummary& contact : primitive.contacts)
      text += Format("    %s planted, phase %.2f to %.2f\n", contact.part.c_str(), contact.from_phase, contact.to_phase);
  }
  text += Format("\n%-*s  %5s %11s %12s %9s %9s %9s %14s %12s\n", 2 * width + 4, "transition", "pairs", "probability",
                 "length scale", "signal", "linear", "noise", "log marginal", "unseen error");
  for (const EdgeSummary& edge : summary.edges) {
    const std::string ends = FullName(summary.primitives.at(static_cast<std::size_t>(edge.from))) + " -> " +
                             FullName(summary.primitives.at(static_cast<std::size_t>(edge.to)));
    text += Format("%-*.130s  %5d %11.3f %12.4g %9.4g %9.4g %9.4g %14.2f %12.3f\n", 2 * width + 4, ends.c_str(), edge.pairs,
                   edge.probability, edge.length_scale, edge.signal_variance, edge.linear_variance, edge.noise_variance,
                   edge.log_marginal_likelihood, edge.unseen_error);
  }
  if (!summary.changes.empty()) text += "\nmade steps from one action into another, taken where a clip is asked to change\n";
  for (const ChangeSummary& change : summary.changes) {
    text += "- " + (change.style.empty() ? "" : change.style + "/") + change.name + ": begins as " +
            summary.primitives.at(static_cast<std::size_t>(change.from)).name + ", ends as " +
            summary.primitives.at(static_cast<std::size_t>(change.to)).name + "\n";
  }
  if (!summary.notes.empty()) text += "\nnotes\n";
  for (const std::string& note : summary.notes) text += "- " + note + "\n";
  return text;
}

}  // namespace morphograph
