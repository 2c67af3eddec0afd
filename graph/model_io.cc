#include "graph/model_io.h"

#include <xxhash.h>
#include <zstd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>

#include "datasets/atomic_file.h"
#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "graph/internal/array_store.h"
#include "graph/internal/skeleton_json.h"
#include "graph/recorded_motion.h"

namespace morphograph {
namespace {

using internal::ArrayReader;
using internal::ArrayWriter;
using internal::SkeletonFromJson;
using internal::SkeletonToJson;
using nlohmann::json;

constexpr std::string_view kMagic = "MORPHGRF";
constexpr size_t kHeaderBytes = 32;
constexpr size_t kCheckedBytes = 24;  // of the header; the checksum follows
constexpr int kCompressionLevel = 12;
constexpr std::uint64_t kLargestPayload = 1ull << 30;

// A program that knows one action a model would mix them up, so models of several are no file of that version.
constexpr int kOneActionVersion = 2;

constexpr const char* kEulerName = "euler";  // of rotations; log maps are not named

constexpr std::array kLabels = {KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance, KeyframeLabel::kDoubleStance,
                                KeyframeLabel::kStanding};
constexpr std::array kForms = {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal};

template <typename Values, typename NameOf>
auto FromName(const Values& values, const NameOf& name_of, const std::string& name) {
  for (const auto value : values) {
    if (name_of(value) == name) return value;
  }
  throw std::runtime_error("unknown name '" + name + "'");
}

template <typename T>
void Put(std::string* bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes->append(raw, sizeof value);
}

template <typename T>
T Get(std::string_view bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// ---- writing ----

json StyleToJson(const GraphStyle& style, ArrayWriter* arrays) {
  Eigen::MatrixXd rotations(4, style.mean_rotations.size());
  for (size_t j = 0; j < style.mean_rotations.size(); ++j) {
    const Eigen::Quaterniond& q = style.mean_rotations[j];
    rotations.col(static_cast<Eigen::Index>(j)) << q.w(), q.x(), q.y(), q.z();
  }
  Eigen::MatrixXd heels(3, 2), heights(2, 2), lowest(2, 2);
  for (int side = 0; side < 2; ++side) {
    heels.col(side) = style.feet.heel_offset_m[side];
    heights.col(side) << style.feet.heel_height_m[side], style.feet.ball_height_m[side];
    lowest.col(side) << style.feet.heel_lowest_m[side], style.feet.ball_lowest_m[side];
  }
  json value = {{"name", style.name},
                {"mean_rotations", arrays->Doubles(rotations)},
                {"heel_offset_m", arrays->Doubles(heels)},
                {"feet_heights_m", arrays->Doubles(heights)},
                {"feet_lowest_m", arrays->Doubles(lowest)}};
  if (!style.other_action.empty()) value["action"] = style.other_action;
  return value;
}

json MixtureToJson(const MotionPrimitive& primitive, ArrayWriter* arrays) {
  json components = json::array();
  for (const MixtureComponent& component : primitive.mixture.components()) {
    components.push_back({{"log_weight", component.log_weight},
                          {"mean", arrays->Floats(component.mean.cast<float>())},
                          {"cholesky", arrays->Floats(component.cholesky.cast<float>())}});
  }
  return {{"form", CovarianceFormName(primitive.covariance_form)}, {"components", components}};
}

// Rows of a contact map that tell the rows of the contacts from `first` to before `end`, sample after sample.
std::vector<Eigen::Index> ContactMapRows(int first, int end) {
  std::vector<Eigen::Index> rows;
  for (int sample = 0; sample < kPhaseSamples; ++sample) {
    for (int row = first; row < end; ++row) rows.push_back(sample * kContactRows + row);
  }
  return rows;
}

json PrimitiveToJson(const MotionPrimitive& primitive, ArrayWriter* arrays) {
  json value = {{"name", primitive.name},
          {"style", primitive.style_index},
          {"start", KeyframeLabelName(primitive.start)},
          {"end", KeyframeLabelName(primitive.end)},
          {"examples", primitive.examples},
          {"made_examples", primitive.made_examples},
          {"initial_weight", primitive.initial_weight},
          {"variance_kept", primitive.reduction.variance_kept},
          {"latent_radius", primitive.latent_radius},
          {"mean", arrays->Floats(primitive.reduction.mean.cast<float>())},
          {"basis", arrays->Shorts(primitive.reduction.basis)},
          {"contacts", arrays->Doubles(primitive.contacts.topRows(kFootParts))},
          {"contact_motion", arrays->Floats(primitive.contacts.bottomRows(kContactRows - kFootParts).cast<float>())},
          {"mixture", MixtureToJson(primitive, arrays)}};
  if (primitive.contact_map.size() > 0) {
    const Eigen::MatrixXf chances = primitive.contact_map(ContactMapRows(0, kFootParts), Eigen::all);
    if (!chances.isZero(0)) value["chance_map"] = arrays->Shorts(chances);
    value["contact_map"] = arrays->Shorts(primitive.contact_map(ContactMapRows(kFootParts, kContactRows), Eigen::all));
  }
  if (!primitive.manner.empty()) {
    value["manner"] = {{"share", arrays->Doubles(primitive.manner.share)},
                       {"captured", arrays->Shorts(primitive.manner.captured)},
                       {"met", arrays->Floats(primitive.manner.met)},
                       {"components", arrays->Floats(primitive.manner.components)},
                       {"steps", primitive.manner.steps},
                       {"seconds", primitive.manner.seconds}};
  }
  return value;
}

json EdgeToJson(int from, int to, const TransitionModel& model, ArrayWriter* arrays) {
  json edge = {{"from", from},
               {"to", to},
               {"pairs", model.pairs},
               {"probability", model.probability},
               {"length_scale", model.length_scale},
               {"signal_variance", model.signal_variance},
               {"linear_variance", model.linear_variance},
               {"noise_variance", model.noise_variance},
               {"unseen_error", model.unseen_error},
               {"log_marginal_likelihood", model.log_marginal_likelihood},
               {"component_chances", arrays->Doubles(model.component_chances)},
               {"linear", arrays->Shorts(model.linear)},
               {"residuals", arrays->Shorts(model.residuals)},
               {"residual_component", model.residual_component},
               {"noise_cholesky", arrays->Shorts(model.noise_cholesky.cast<float>())}};
  if (model.process) {
    edge["process"] = {{"inputs", arrays->Shorts(model.process->inputs().cast<float>())},
                       {"alpha", arrays->Shorts(model.process->alpha().cast<float>())}};
  }
  return edge;
}

json RecordingsToJson(const RecordedMotion& motion, ArrayWriter* arrays) {
  json clips = json::array();
  for (const RecordedClip& clip : motion.clips)
    clips.push_back({{"name", clip.name}, {"style", clip.style}, {"frame_rate_hz", clip.frame_rate_hz}, {"frames", clip.frames}});
  Eigen::MatrixXd steps(4, motion.steps.size());
  for (size_t s = 0; s < motion.steps.size(); ++s) {
    const RecordedStep& step = motion.steps[s];
    steps.col(static_cast<Eigen::Index>(s)) << step.clip, step.start_frame, step.end_frame, step.left;
  }
  return {{"clips", clips},
          {"steps", arrays->Doubles(steps)},
          {"roots", arrays->Floats(motion.roots)},
          {"rotations", arrays->Shorts(motion.rotations)}};
}

json ChangeToJson(const ActionChange& change) {
  const auto effort = [](const ChangeEffort& of) { return json{{"speed_m_s2", of.speed_m_s2}, {"body_m_s2", of.body_m_s2}}; };
  return {{"name", change.name},
          {"from", change.from},
          {"to", change.to},
          {"examples", change.examples},
          {"near_examples", change.near_examples},
          {"least", effort(change.least)},
          {"captured", effort(change.captured)}};
}

json GraphToJson(const MotionGraph& graph, ArrayWriter* arrays) {
  const ModelProvenance& provenance = graph.provenance();
  json styles = json::array(), primitives = json::array(), edges = json::array();
  for (const GraphStyle& style : graph.styles()) styles.push_back(StyleToJson(style, arrays));
  for (int p = 0; p < graph.primitive_count(); ++p) primitives.push_back(PrimitiveToJson(graph.primitive(p), arrays));
  for (int e = 0; e < graph.edge_count(); ++e) {
    edges.push_back(EdgeToJson(graph.edge_from(e), graph.edge_to(e), graph.transition(e), arrays));
  }
  json model = {{"name", graph.name()},
          {"action", graph.action()},
          {"frame_rate_hz", graph.frame_rate_hz()},
          {"provenance",
           {{"source", provenance.source},
            {"licence", provenance.licence},
            {"attribution", provenance.attribution},
            {"command", provenance.command},
            {"clips", provenance.clips},
            {"frames", provenance.frames},
            {"notes", provenance.notes}}},
          {"skeleton", SkeletonToJson(graph.skeleton())},
          {"active_joints", graph.layout().active_joints()},
          {"styles", styles},
          {"primitives", primitives},
          {"edges", edges}};
  for (const ActionChange& change : graph.changes()) model["changes"].push_back(ChangeToJson(change));
  if (graph.layout().rotation_form() == RotationForm::kEuler) model["rotations"] = kEulerName;
  if (graph.recordings()) model["recordings"] = RecordingsToJson(*graph.recordings(), arrays);
  return model;
}

// ---- reading ----

GraphStyle StyleFromJson(const json& value, const ArrayReader& arrays) {
  GraphStyle style;
  style.name = value.at("name").get<std::string>();
  style.other_action = value.value("action", std::string());  // from version 3 on, and of other actions only
  const Eigen::MatrixXd rotations = arrays.Doubles(value.at("mean_rotations"));
  const Eigen::MatrixXd heels = arrays.Doubles(value.at("heel_offset_m"));
  const Eigen::MatrixXd heights = arrays.Doubles(value.at("feet_heights_m"));
  // Files of older programs do not say how low feet come: then the floor alone holds them.
  const Eigen::MatrixXd lowest =
      value.contains("feet_lowest_m") ? arrays.Doubles(value.at("feet_lowest_m")) : Eigen::MatrixXd::Zero(2, 2);
  if (lowest.rows() != 2 || lowest.cols() != 2) throw std::runtime_error("feet_lowest_m has the wrong size");
  if (rotations.rows() != 4 || heels.rows() != 3 || heels.cols() != 2 || heights.rows() != 2 || heights.cols() != 2) {
    throw std::runtime_error("a style has arrays of the wrong size");
  }
  for (Eigen::Index j = 0; j < rotations.cols(); ++j) {
    const Eigen::Quaterniond rotation(rotations(0, j), rotations(1, j), rotations(2, j), rotations(3, j));
    if (std::abs(rotation.norm() - 1) > 1e-9) throw std::runtime_error("a mean rotation is not a unit quaternion");
    style.mean_rotations.push_back(rotation);
  }
  for (int side = 0; side < 2; ++side) {
    style.feet.heel_offset_m[side] = heels.col(side);
    style.feet.heel_height_m[side] = heights(0, side);
    style.feet.ball_height_m[side] = heights(1, side);
    style.feet.heel_lowest_m[side] = lowest(0, side);
    style.feet.ball_lowest_m[side] = lowest(1, side);
  }
  return style;
}

Eigen::MatrixXf ContactMapFromJson(const json& value, const ArrayReader& arrays) {
  const Eigen::MatrixXf motion = arrays.Floats(value.at("contact_map"));
  Eigen::MatrixXf map = Eigen::MatrixXf::Zero(kContactRows * kPhaseSamples, motion.cols());
  const auto take = [&](const Eigen::MatrixXf& part, int first, int end, const char* name) {
    const std::vector<Eigen::Index> rows = ContactMapRows(first, end);
    if (part.rows() != static_cast<Eigen::Index>(rows.size()) || part.cols() != map.cols()) {
      throw std::runtime_error(std::string(name) + " of the wrong size");
    }
    map(rows, Eigen::all) = part;
  };
  take(motion, kFootParts, kContactRows, "contact_map");
  if (value.contains("chance_map")) take(arrays.Floats(value.at("chance_map")), 0, kFootParts, "chance_map");
  return map;
}

// As files had it that do not say how often walks met each mixture component: as the factors alone would have them.
Eigen::MatrixXf MetByFactors(const MotionPrimitive& primitive) {
  Eigen::MatrixXf met = primitive.manner.components;
  if (met.rows() != primitive.mixture.size()) throw std::runtime_error("a manner of the wrong size");
  for (int c = 0; c < primitive.mixture.size(); ++c) met.row(c) *= static_cast<float>(std::exp(primitive.mixture.Component(c).log_weight));
  for (Eigen::Index walk = 0; walk < met.cols(); ++walk) met.col(walk) /= met.col(walk).sum();
  return met;
}

MotionPrimitive PrimitiveFromJson(const json& value, const std::vector<GraphStyle>& styles, const ArrayReader& arrays) {
  const auto label = [&](const char* key) { return FromName(kLabels, KeyframeLabelName, value.at(key).get<std::string>()); };
  MotionPrimitive primitive;
  primitive.name = value.at("name").get<std::string>();
  primitive.style_index = value.at("style").get<int>();
  primitive.style = styles.at(static_cast<size_t>(primitive.style_index)).name;
  primitive.start = label("start");
  primitive.end = label("end");
  primitive.examples = value.at("examples").get<int>();
  primitive.made_examples = value.at("made_examples").get<int>();
  primitive.initial_weight = value.at("initial_weight").get<double>();
  primitive.latent_radius = value.at("latent_radius").get<double>();
  primitive.reduction.variance_kept = value.at("variance_kept").get<double>();
  primitive.reduction.mean = arrays.Floats(value.at("mean")).cast<double>().reshaped();
  primitive.reduction.basis = arrays.Floats(value.at("basis"));
  const Eigen::MatrixXd contacts = arrays.Doubles(value.at("contacts"));
  if (contacts.rows() != kFootParts || contacts.cols() != kPhaseSamples) throw std::runtime_error("contacts of the wrong size");
  primitive.contacts.topRows(kFootParts) = contacts;
  if (value.contains("contact_motion")) {
    const Eigen::MatrixXf motion = arrays.Floats(value.at("contact_motion"));
    if (motion.rows() != kContactRows - kFootParts || motion.cols() != kPhaseSamples) {
      throw std::runtime_error("contact_motion of the wrong size");
    }
    primitive.contacts.bottomRows(kContactRows - kFootParts) = motion.cast<double>();
  } else {  // files of version 1: planted feet stand still, each part at its style's height
    const FeetGeometry& feet = styles[static_cast<size_t>(primitive.style_index)].feet;
    for (int side = 0; side < 2; ++side) {
      primitive.contacts.row(kPlantedHeight + 2 * side).setConstant(feet.heel_height_m[side]);
      primitive.contacts.row(kPlantedHeight + 2 * side + 1).setConstant(feet.ball_height_m[side]);
    }
  }
  if (value.contains("contact_map")) primitive.contact_map = ContactMapFromJson(value, arrays);
  if (value.contains("manner")) {  // not in files of version 1
    const json& manner = value.at("manner");
    primitive.manner.share = arrays.Doubles(manner.at("share")).reshaped();
    primitive.manner.captured = arrays.Floats(manner.at("captured"));
    primitive.manner.components = arrays.Floats(manner.at("components"));
    primitive.manner.steps = manner.at("steps").get<std::vector<int>>();
    primitive.manner.seconds = manner.at("seconds").get<std::vector<float>>();
  }
  const json& mixture = value.at("mixture");
  primitive.covariance_form = FromName(kForms, CovarianceFormName, mixture.at("form").get<std::string>());
  std::vector<MixtureComponent> components;
  for (const json& entry : mixture.at("components")) {
    components.push_back({entry.at("log_weight").get<double>(), arrays.Floats(entry.at("mean")).cast<double>().reshaped(),
                          arrays.Floats(entry.at("cholesky")).cast<double>()});
  }
  primitive.mixture = GaussianMixture(std::move(components));
  if (value.contains("manner")) {
    const json& manner = value.at("manner");
    primitive.manner.met = manner.contains("met") ? arrays.Floats(manner.at("met")) : MetByFactors(primitive);
  }
  return primitive;
}

GraphEdge EdgeFromJson(const json& value, const ArrayReader& arrays) {
  GraphEdge edge;
  edge.from = value.at("from").get<int>();
  edge.to = value.at("to").get<int>();
  TransitionModel& model = edge.model;
  model.pairs = value.at("pairs").get<int>();
  model.probability = value.at("probability").get<double>();
  model.length_scale = value.at("length_scale").get<double>();
  model.signal_variance = value.at("signal_variance").get<double>();
  model.noise_variance = value.at("noise_variance").get<double>();
  model.linear_variance = value.value("linear_variance", 0.0);  // not in files of older programs, as little as the next
  model.unseen_error = value.value("unseen_error", 0.0);
  model.log_marginal_likelihood = value.at("log_marginal_likelihood").get<double>();
  model.component_chances = arrays.Doubles(value.at("component_chances"));
  model.linear = arrays.Floats(value.at("linear"));
  model.residuals = arrays.Floats(value.at("residuals"));
  model.residual_component = value.at("residual_component").get<std::vector<int>>();
  model.noise_cholesky = arrays.Floats(value.at("noise_cholesky")).cast<double>();
  if (value.contains("process")) {
    const json& process = value.at("process");
    GaussianProcessKernel kernel;
    kernel.length_scale = model.length_scale;
    kernel.signal_variance = model.signal_variance;
    kernel.noise_variance = model.noise_variance;
    model.process.emplace(kernel, arrays.Floats(process.at("inputs")).cast<double>(),
                          arrays.Floats(process.at("alpha")).cast<double>(), model.log_marginal_likelihood);
  }
  return edge;
}

RecordedMotion RecordingsFromJson(const json& value, const ArrayReader& arrays) {
  RecordedMotion motion;
  int first = 0;
  for (const json& clip : value.at("clips")) {
    motion.clips.push_back({clip.at("name").get<std::string>(), clip.at("style").get<std::string>(), clip.at("frame_rate_hz").get<double>(), first,
                            clip.at("frames").get<int>()});
    if (motion.clips.back().frames < 0 || motion.clips.back().frames > std::numeric_limits<int>::max() - first) throw std::runtime_error("a recorded clip is of the wrong size");
    first += motion.clips.back().frames;
  }
  motion.roots = arrays.Floats(value.at("roots"));
  motion.rotations = arrays.Floats(value.at("rotations"));
  const Eigen::MatrixXd steps = arrays.Doubles(value.at("steps"));
  if (steps.rows() != 4) throw std::runtime_error("recorded steps of the wrong size");
  for (Eigen::Index s = 0; s < steps.cols(); ++s) {
    const double clip = steps(0, s);
    if (!(clip >= 0) || clip >= static_cast<double>(motion.clips.size())) throw std::runtime_error("a recorded step is of no clip");
    motion.steps.push_back({static_cast<int>(clip), steps(1, s), steps(2, s), steps(3, s) != 0});
  }
  return motion;
}

ActionChange ChangeFromJson(const json& value) {
  const auto effort = [](const json& of) { return ChangeEffort{of.at("speed_m_s2").get<double>(), of.at("body_m_s2").get<double>()}; };
  return {value.at("name").get<std::string>(), value.at("from").get<int>(),          value.at("to").get<int>(),
          value.at("examples").get<int>(),     value.at("near_examples").get<int>(), effort(value.at("least")),
          effort(value.at("captured"))};
}

GraphContents ContentsFromJson(const json& value, const ArrayReader& arrays) {
  GraphContents contents;
  contents.name = value.at("name").get<std::string>();
  contents.action = value.at("action").get<std::string>();
  contents.frame_rate_hz = value.at("frame_rate_hz").get<double>();
  const json& provenance = value.at("provenance");
  contents.provenance = {provenance.at("source").get<std::string>(),      provenance.at("licence").get<std::string>(),
                         provenance.at("attribution").get<std::string>(), provenance.at("command").get<std::string>(),
                         provenance.at("clips").get<int>(),               provenance.at("frames").get<int>(),
                         provenance.at("notes").get<std::vector<std::string>>()};
  const std::shared_ptr<const Skeleton> skeleton = SkeletonFromJson(value.at("skeleton"));
  std::vector<int> active = value.at("active_joints").get<std::vector<int>>();
  for (const int joint : active) {
    if (joint < 0 || joint >= skeleton->joint_count()) throw std::runtime_error("an active joint does not exist");
  }
  RotationForm form = RotationForm::kLogMap;
  if (value.contains("rotations")) {
    if (value.at("rotations").get<std::string>() != kEulerName) throw std::runtime_error("rotations of an unknown form");
    form = RotationForm::kEuler;
  }
  contents.layout = PoseLayout(skeleton, std::move(active), form);
  for (const json& style : value.at("styles")) contents.styles.push_back(StyleFromJson(style, arrays));
  for (const json& primitive : value.at("primitives")) {
    contents.primitives.push_back(PrimitiveFromJson(primitive, contents.styles, arrays));
  }
  for (const json& edge : value.at("edges")) contents.edges.push_back(EdgeFromJson(edge, arrays));
  if (value.contains("recordings"))
    contents.recordings = std::make_shared<const RecordedMotion>(RecordingsFromJson(value.at("recordings"), arrays));
  if (value.contains("changes")) {
    for (const json& change : value.at("changes")) contents.changes.push_back(ChangeFromJson(change));
  }
  return contents;
}

std::string Hash128(std::string_view bytes) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes.data(), bytes.size()));
  static constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    text += kHex[byte >> 4];
    text += kHex[byte & 15];
  }
  return text;
}

std::uint64_t Checksum(std::string_view bytes) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  if (!state) throw std::bad_alloc();
  XXH3_64bits_reset(state.get());
  XXH3_64bits_update(state.get(), bytes.data(), kCheckedBytes);
  XXH3_64bits_update(state.get(), bytes.data() + kHeaderBytes, bytes.size() - kHeaderBytes);
  return XXH3_64bits_digest(state.get());
}

std::string Decompress(std::string_view compressed, std::uint64_t size) {
  std::string payload(size, '\0');
  const size_t written = ZSTD_decompress(payload.data(), payload.size(), compressed.data(), compressed.size());
  if (ZSTD_isError(written) || written != size) throw std::runtime_error("the payload does not decompress");
  return payload;
}

}  // namespace

int FormatVersionOf(const MotionGraph& graph) { return graph.action_names().size() > 1 ? kModelFormatVersion : kOneActionVersion; }

std::string SerialiseModel(const MotionGraph& graph) {
  ArrayWriter arrays;
  const std::string text = GraphToJson(graph, &arrays).dump(-1, ' ', false, json::error_handler_t::replace);
  std::string payload;
  Put<std::uint64_t>(&payload, text.size());
  payload += text;
  payload += arrays.bytes();

  std::string bytes(kMagic);
  Put<std::uint32_t>(&bytes, static_cast<std::uint32_t>(FormatVersionOf(graph)));
  Put<std::uint32_t>(&bytes, 0);
  Put<std::uint64_t>(&bytes, payload.size());
  Put<std::uint64_t>(&bytes, 0);  // the checksum, below
  std::string compressed(ZSTD_compressBound(payload.size()), '\0');
  const size_t size =
      ZSTD_compress(compressed.data(), compressed.size(), payload.data(), payload.size(), kCompressionLevel);
  if (ZSTD_isError(size)) throw std::runtime_error("SerialiseModel: compression failed");
  bytes.append(compressed, 0, size);
  const std::uint64_t checksum = Checksum(bytes);
  std::memcpy(bytes.data() + kCheckedBytes, &checksum, sizeof checksum);
  return bytes;
}

std::shared_ptr<const MotionGraph> ParseModel(std::string_view bytes, const std::string& source) {
  if (bytes.size() < kMagic.size() || bytes.substr(0, kMagic.size()) != kMagic) {
    throw DatasetError(source, "not a Morphograph model");
  }
  if (bytes.size() < kHeaderBytes) throw DatasetError(source, "the model is cut short");
  const auto version = Get<std::uint32_t>(bytes, 8);
  if (version > static_cast<std::uint32_t>(kModelFormatVersion)) {
    throw DatasetError(source, "the model has format version " + std::to_string(version) + "; this program reads up to " +
                                   std::to_string(kModelFormatVersion));
  }
  if (version == 0) throw DatasetError(source, "the model has format version 0, which does not exist");
  if (Checksum(bytes) != Get<std::uint64_t>(bytes, kCheckedBytes)) {
    throw DatasetError(source, "the model is damaged or cut short: its checksum does not match");
  }
  const auto payload_size = Get<std::uint64_t>(bytes, 16);
  if (payload_size > kLargestPayload) throw DatasetError(source, "the model claims to be larger than 1 GiB");
  try {
    const std::string payload = Decompress(bytes.substr(kHeaderBytes), payload_size);
    if (payload.size() < 8) throw std::runtime_error("the payload is too short");
    const auto text_size = Get<std::uint64_t>(payload, 0);
    if (text_size > payload.size() - 8) throw std::runtime_error("the description reaches beyond the file");
    const std::string_view view(payload);
    const json description = json::parse(view.substr(8, text_size));
    return std::make_shared<MotionGraph>(ContentsFromJson(description, ArrayReader(view.substr(8 + text_size))), Hash128(bytes));
  } catch (const std::exception& error) {
    throw DatasetError(source, std::string("the model cannot be read: ") + error.what());
  }
}

std::shared_ptr<const MotionGraph> LoadModel(const std::filesystem::path& path) {
  return ParseModel(ReadFileText(path), path.string());
}

void SaveModel(const MotionGraph& graph, const std::filesystem::path& path) {
  WriteFileAtomically(path, SerialiseModel(graph));
}

}  // namespace morphograph
